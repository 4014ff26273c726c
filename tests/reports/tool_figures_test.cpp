// SPDX-License-Identifier: MIT
#include "reports/tool_figures.hpp"

#include <algorithm>

#include "reports/run_report.hpp"
#include "reports/tool_facts.hpp"
#include "reports/tool_pass.hpp"
#include "reports/trace_figures.hpp"
#include "tests/check.hpp"
#include "tests/reports/tool_trace.hpp"

using namespace palpate;

namespace {

bool contains(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

std::vector<std::string> ids_of(const std::vector<Figure>& figures) {
  std::vector<std::string> ids;
  for (const Figure& figure : figures) { ids.push_back(figure.id); }
  return ids;
}

const Fact* fact(const std::vector<Fact>& facts, const std::string& label) {
  const auto found = std::ranges::find(facts, label, &Fact::label);
  return found == facts.end() ? nullptr : &*found;
}

void set(Trace& trace, const std::string& name, double value) {
  for (Column& column : trace.columns) {
    if (column.name == name) { column.values.assign(column.values.size(), value); }
  }
}

}  // namespace

TEST("the first pass takes each depth once, from the last tick before the tool moves") {
  const Trace trace = sample::needle_trace();
  const std::vector<std::size_t> rows = first_pass(trace);
  CHECK(rows.size() == 11 && rows.front() == 1 && rows.back() == 11);
}

TEST("layers over depth come from the way in alone and meet where the label changes") {
  const std::vector<Zone> zones = layers_over_depth(sample::needle_trace());
  CHECK(zones.size() == 3);
  CHECK(zones[0].label == "skin" && zones[1].label == "ligament");
  const double rounding = 1e-12;  // of millimetres from metres
  CHECK_NEAR(zones[0].begin, 1.0, rounding);
  CHECK_NEAR(zones[0].end, 3.0, rounding);
  CHECK_NEAR(zones[1].begin, 3.0, rounding);
  CHECK_NEAR(zones[2].end, 10.0, rounding);
}

TEST("layers over time are those of the way in and of the way out") {
  const std::vector<Zone> zones = layers_over_time(sample::needle_trace());
  CHECK(zones.size() == 5);
  CHECK(zones[0].label == zones[4].label && zones[1].label == zones[3].label);
}

TEST("a tip that rests on the skin does not fill the picture with zones") {
  Trace trace = sample::needle_trace();
  for (int n = 0; n < 4000; ++n) {
    trace.time.push_back(2.2 + 1e-3 * n);
    trace.text_columns[0].values.push_back(n % 2 == 0 ? "skin" : "");
    for (Column& column : trace.columns) { column.values.push_back(0.0); }
  }
  CHECK(layers_over_time(trace).size() == 5);
}

TEST("a needle's figures come in order, in mm, N and mmHg, with their events") {
  const std::vector<Figure> figures = tool_figures(sample::needle_trace());
  CHECK((ids_of(figures) == std::vector<std::string>{"force-over-depth", "force-parts",
                                                     "force-over-time", "pressure-over-time"}));
  CHECK(figures[0].x.label == "tip depth (mm)" && figures[0].series[0].x.size() == 22);
  CHECK_NEAR(figures[0].series[0].x[11], 10.0, 1e-12);  // rounding of the unit
  CHECK(figures[0].marks.size() == 4 && figures[0].marks[2].label == "loss of resistance");
  CHECK_NEAR(figures[0].marks[2].x, 7.0, 1e-12);
  CHECK(figures[2].zones.empty() && figures[2].marks[3].x == 2.1);
  CHECK_NEAR(figures[3].series[0].y[0], 200.0, 1e-9);  // 26664.4 Pa
  CHECK(figures[3].zones.size() == 5 && figures[3].y.label == "pressure (mmHg)");
}

TEST("the parts are stacked without gaps and end at the sum") {
  const Figure figure = tool_figures(sample::needle_trace()).at(1);
  CHECK(figure.series.size() == 4 && figure.zones.size() == 3);
  for (std::size_t n = 0; n + 1 < 3; ++n) {
    CHECK(figure.series[n].style == Series::Style::area);
    CHECK(figure.series[n + 1].y == figure.series[n].y2);
  }
  const Series& sum = figure.series[3];
  CHECK(sum.style == Series::Style::line && sum.x == figure.series[0].x);
  for (std::size_t n = 0; n < sum.y.size(); ++n) {
    CHECK_NEAR(figure.series[2].y2[n], sum.y[n], 1e-12);  // rounding of a sum of three
  }
}

TEST("a probe shows its force over depth and time, and nothing else") {
  const std::vector<Figure> figures = tool_figures(sample::probe_trace());
  CHECK((ids_of(figures) == std::vector<std::string>{"force-over-depth", "force-over-time"}));
  CHECK(figures[0].zones.empty());
}

TEST("lateral force is shown when there is any") {
  Trace trace = sample::needle_trace();
  set(trace, "tool.lateral_n", 0.3);
  CHECK(ids_of(tool_figures(trace)).back() == "lateral-force");
}

TEST("nothing is shown twice, and a trace without a tool has no such figure") {
  CHECK(figures_over_time(sample::needle_trace()).empty());
  CHECK(tool_traces(sample::needle_trace()).size() == 2);
  CHECK(tool_figures(Trace{.time = {0.0, 1.0}}).empty());
  CHECK(tool_facts(Trace{.time = {0.0, 1.0}}).empty());
}

TEST("the facts say the peak force, where it was, and the loss of resistance") {
  const std::vector<Fact> facts = tool_facts(sample::needle_trace());
  const Fact* peak = fact(facts, "peak force");
  CHECK(peak != nullptr && contains(peak->value, "8") && contains(peak->explanation, "ligament"));
  const Fact* loss = fact(facts, "loss of resistance");
  CHECK(loss != nullptr && contains(loss->value, "7"));
  CHECK(loss != nullptr && contains(loss->explanation, "falls by 4.5"));  // 8 N to 3.5 N
  const Fact* pressure = fact(facts, "peak pressure");
  CHECK(pressure != nullptr && contains(pressure->value, "200"));
}

TEST("an event has the depth, and the force one tick before it and at it") {
  const Table table = events_table(sample::needle_trace());
  CHECK(table.rows.size() == 4 && table.columns.size() == 6);
  CHECK(std::get<std::string>(table.rows[2][1]) == "loss of resistance");
  CHECK_NEAR(std::get<double>(table.rows[2][3]), 7.0, 1e-12);  // rounding of the unit
  CHECK_NEAR(std::get<double>(table.rows[2][4]), 8.0, 1e-12);
  CHECK_NEAR(std::get<double>(table.rows[2][5]), 3.5, 1e-12);
}

TEST("a run that broke off or holds no numbers still has a page") {
  Trace trace = sample::needle_trace();
  set(trace, "tool.depth_m", std::nan(""));
  set(trace, "tool.force_n", std::nan(""));
  CHECK(contains(to_html(RunReport{.title = "broken"}, trace), "Forces on the tool"));
  Trace one = sample::needle_trace();
  one.time.resize(1);
  for (Column& column : one.columns) { column.values.resize(1); }
  CHECK(contains(to_html(RunReport{.title = "short"}, one), "short"));
}

TEST("the page begins with the tool, escapes its layers and gives the same bytes twice") {
  const RunReport report{.title = "needle", .facts = {{"nodes", "27", ""}}};
  const std::string html = to_html(report, sample::needle_trace());
  CHECK(html.find("Key facts") < html.find("Forces on the tool"));
  CHECK(html.find("Forces on the tool") < html.find("<h2>Events"));
  CHECK(!contains(html, "epidural <space>"));
  CHECK(html == to_html(report, sample::needle_trace()));
}
