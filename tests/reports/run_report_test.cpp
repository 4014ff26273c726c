// SPDX-License-Identifier: MIT

#include "reports/run_report.hpp"

#include "model/problem/recording.hpp"
#include "reports/plot/trace_figures.hpp"
#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate;

Trace moving_block() {
  Trace trace{.time = {0.0, 0.1, 0.2}};
  trace.columns = {{"tip</script>.x_m", "m", {1.0, 1.1, std::nan("")}},
                   {"tip</script>.y_m", "m", {0.0, 0.0, 0.0}},
                   {"tip</script>.fx_n", "N", {0.0, 1.0, 2.0}}};
  trace.events = {{0.1, "puncture", "skin <1>"}};
  NodeVectors rest(3, 27);
  for (int i = 0; i < 27; ++i) {
    rest.col(i) << 0.01 * (i % 3), 0.01 * (i / 3 % 3), 0.01 * (i / 9);
  }
  NodeVectors moved = rest;
  moved(2, 13) += 1e-4;
  trace.frames.time = {0.0, 0.2};
  trace.frames.position = {rest, moved};
  return trace;
}

TEST("columns of one record and unit share a figure, and positions start at zero") {
  const std::vector<Figure> figures = figures_over_time(moving_block());
  REQUIRE(figures.size() == 2);
  CHECK(figures[0].series.size() == 2);
  CHECK(figures[0].series[0].y[0] == 0.0);
  CHECK_NEAR(figures[0].series[0].y[1], 0.1, 1e-15);  // rounding of a difference near one
  CHECK(figures[0].series[1].label == "y");
  CHECK(figures[1].series[0].label == "fx");
}

TEST("the page makes no request, escapes what it shows and gives the same bytes twice") {
  const RunReport report{.title = "<run>",
                         .held = false,
                         .verdict = "Diverged at 0.1 s",
                         .facts = {{"nodes", "27", "<all>"}},
                         .skipped = {"no <needle>"},
                         .warnings = {"a </script> b"}};
  const std::string html = to_html(report, moving_block());
  CHECK_LACKS(html, "src=\"http", "href=\"http", "url(http", "@import", "sourceMappingURL", "<run>",
              "<all>", "<needle>", "tip</script>", "skin <1>");
  CHECK_CONTAINS(html, "class=\"verdict fail\"", "new Dygraph");
  CHECK(html == to_html(report, moving_block()));
}

TEST("a page begins with what changed since the last run, and a first run has nothing to compare") {
  RunReport report{.trust = {{"spacing", "3 %", ""}}};
  CHECK_LACKS(to_html(report, moving_block()), "What changed");
  report.changes = {"peak force 2 N, before: 1 N"};
  const std::string html = to_html(report, moving_block());
  CHECK_CONTAINS(html, "peak force 2 N, before: 1 N");
  CHECK(html.find("What changed since the last run") < html.find("How far to trust this"));
  report.changes = std::vector<std::string>{};
  CHECK_CONTAINS(to_html(report, moving_block()), "Nothing: verdict");
}

// Synthetic trace of a needle through skin, ligament and epidural space and back: 1 mm per tick.

std::string layer_at(double depth_mm) {
  return depth_mm <= 0.0  ? ""
         : depth_mm < 3.0 ? "skin"
         : depth_mm < 7.0 ? "ligament"
                          : "epidural <space>";
}

/// Depths 0, 0, 1, ..., 10, 9, ..., 0 mm; cutting 2 N in the skin and 5 N in the ligament while it
/// advances, friction 0.5 N per mm with the sign of the motion.
Trace needle_trace() {
  Trace trace;
  trace.columns = {{"tool.depth_m", "m", {}},     {"tool.force_n", "N", {}},
                   {"tool.cutting_n", "N", {}},   {"tool.friction_n", "N", {}},
                   {"tool.stiffness_n", "N", {}}, {"syringe.pressure_pa", "Pa", {}},
                   {"tool.lateral_n", "N", {}}};
  trace.text_columns = {{"tool.layer", {}}, {"tool.event", std::vector<std::string>(22)}};
  for (int n = 0; n <= 21; ++n) {
    const double mm = n < 1 ? 0.0 : n <= 11 ? n - 1.0 : 21.0 - n;
    const bool advances = n > 1 && n <= 11;
    const std::string where = layer_at(mm);
    const double cutting = !advances             ? 0.0
                           : where == "skin"     ? 2.0
                           : where == "ligament" ? 5.0
                                                 : 0.0;
    const double friction = (advances ? 0.5 : -0.5) * mm;
    const double pressure = (where.starts_with("epidural") ? 1.0 : 200.0) * pascals_per_mmhg;
    trace.time.push_back(0.1 * n);
    const double row[] = {1e-3 * mm, cutting + friction, cutting, friction, 0.0, pressure, 1e-9};
    for (std::size_t c = 0; c < std::size(row); ++c) { trace.columns[c].values.push_back(row[c]); }
    trace.text_columns[0].values.push_back(where);
  }
  trace.events = {{0.2, "contact", "skin"},
                  {0.4, "puncture", "ligament"},
                  {0.8, "loss-of-resistance", "epidural <space>"},
                  {2.1, "withdrawn", "skin"}};
  return trace;
}

void set(Trace& trace, std::string_view name, double value) {
  for (Column& column : trace.columns) {
    if (column.name == name) { column.values.assign(column.values.size(), value); }
  }
}

/// Same motion of a blunt tool.
Trace probe_trace() {
  Trace trace = needle_trace();
  std::erase_if(trace.columns, [](const Column& c) { return c.name.starts_with("syringe"); });
  set(trace, "tool.cutting_n", 0.0);
  set(trace, "tool.friction_n", 0.0);
  return trace;
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

const Fact& required(const std::vector<Fact>& facts, const std::string& label) {
  const Fact* found = fact(facts, label);
  REQUIRE(found != nullptr);
  return *found;
}

TEST("the first pass takes each depth once, and its layers meet where the label changes") {
  const std::vector<std::size_t> rows = first_pass(needle_trace());
  REQUIRE(rows.size() == 11);
  CHECK(rows.front() == 1);  // the last tick before the tool moves
  CHECK(rows.back() == 11);
  const std::vector<Zone> zones = layers_over_depth(needle_trace());
  REQUIRE(zones.size() == 3);
  CHECK(zones[0].label == "skin");
  CHECK(zones[1].label == "ligament");
  const double rounding = 1e-12;  // conversion from metres to millimetres
  CHECK_NEAR(zones[0].begin, 1.0, rounding);
  CHECK_NEAR(zones[0].end, 3.0, rounding);
  CHECK_NEAR(zones[1].begin, 3.0, rounding);
  CHECK_NEAR(zones[2].end, 10.0, rounding);
}

TEST("layers over time are those of the way in and of the way out, not of a tip at rest") {
  Trace trace = needle_trace();
  const std::vector<Zone> zones = layers_over_time(trace);
  REQUIRE(zones.size() == 5);
  CHECK(zones[0].label == zones[4].label);
  CHECK(zones[1].label == zones[3].label);
  for (int n = 0; n < 4000; ++n) {  // between skin and air
    trace.time.push_back(2.2 + 1e-3 * n);
    trace.text_columns[0].values.push_back(n % 2 == 0 ? "skin" : "");
    for (Column& column : trace.columns) { column.values.push_back(0.0); }
  }
  CHECK(layers_over_time(trace).size() == 5);
}

TEST("the figures of a needle are in order, in mm, N and mmHg, with their events") {
  const std::vector<Figure> figures = tool_figures(needle_trace());
  CHECK((ids_of(figures) == std::vector<std::string>{"force-over-depth", "force-parts",
                                                     "force-over-time", "pressure-over-time"}));
  CHECK(figures[0].x.label == "tip depth (mm)");
  CHECK(figures[0].series[0].x.size() == 22);
  CHECK_NEAR(figures[0].series[0].x[11], 10.0, 1e-12);  // rounding of the unit
  CHECK(figures[0].marks.size() == 4);
  CHECK(figures[0].marks[2].label == "loss of resistance");
  CHECK_NEAR(figures[0].marks[2].x, 7.0, 1e-12);
  CHECK(figures[2].zones.empty());
  CHECK(figures[2].marks[3].x == 2.1);
  CHECK_NEAR(figures[3].series[0].y[0], 200.0, 1e-9);  // 26664.4 Pa
  CHECK(figures[3].zones.size() == 5);
  CHECK(figures[3].y.label == "pressure (mmHg)");
}

TEST("the parts are stacked without gaps and end at the sum") {
  const Figure figure = tool_figures(needle_trace()).at(1);
  REQUIRE(figure.series.size() == 4);
  CHECK(figure.zones.size() == 3);
  for (std::size_t n = 0; n + 1 < 3; ++n) {
    CHECK(figure.series[n].style == Series::Style::area);
    CHECK(figure.series[n + 1].y == figure.series[n].y2);
  }
  const Series& sum = figure.series[3];
  CHECK(sum.style == Series::Style::line);
  CHECK(sum.x == figure.series[0].x);
  for (std::size_t n = 0; n < sum.y.size(); ++n) {
    CHECK_NEAR(figure.series[2].y2[n], sum.y[n], 1e-12);  // rounding of a sum of three
  }
}

TEST("each tool has the figures of its columns, and a trace without a tool has none") {
  const std::vector<Figure> probe = tool_figures(probe_trace());
  CHECK((ids_of(probe) == std::vector<std::string>{"force-over-depth", "force-over-time"}));
  CHECK(probe[0].zones.empty());
  Trace lateral = needle_trace();
  set(lateral, "tool.lateral_n", 0.3);
  CHECK(ids_of(tool_figures(lateral)).back() == "lateral-force");
  CHECK(figures_over_time(needle_trace()).empty());  // nothing is shown twice
  CHECK(tool_traces(needle_trace()).size() == 2);
  const Trace bare{.time = {0.0, 1.0}};
  CHECK(tool_figures(bare).empty());
  CHECK(tool_facts(bare).empty());
  CHECK(falcon_figures(Trace{}).empty());
}

TEST("the facts are the peak force, its layer, the loss of resistance and the peak pressure") {
  const std::vector<Fact> facts = tool_facts(needle_trace());
  CHECK_CONTAINS(required(facts, "peak force").value, "8");
  CHECK_CONTAINS(required(facts, "peak force").explanation, "ligament");
  CHECK_CONTAINS(required(facts, "loss of resistance").value, "7");
  CHECK_CONTAINS(required(facts, "loss of resistance").explanation, "falls by 4.5");  // 8 to 3.5 N
  CHECK_CONTAINS(required(facts, "peak pressure").value, "200");
}

TEST("an event has the depth, and the force one tick before it and at it") {
  const Table table = events_table(needle_trace());
  REQUIRE(table.rows.size() == 4);
  CHECK(table.columns.size() == 6);
  CHECK(std::get<std::string>(table.rows[2][1]) == "loss of resistance");
  CHECK_NEAR(std::get<double>(table.rows[2][3]), 7.0, 1e-12);  // rounding of the unit
  CHECK_NEAR(std::get<double>(table.rows[2][4]), 8.0, 1e-12);
  CHECK_NEAR(std::get<double>(table.rows[2][5]), 3.5, 1e-12);
}

TEST("the page begins with the tool, also of a run that broke off or holds no numbers") {
  const RunReport report{.title = "needle", .facts = {{"nodes", "27", ""}}};
  Trace trace = needle_trace();
  const std::string html = to_html(report, trace);
  CHECK_ORDER(html, "Key facts", "Forces on the tool", "<h2>Events");
  CHECK_LACKS(html, "epidural <space>");
  CHECK(html == to_html(report, trace));
  CHECK_CONTAINS(to_html(RunReport{.title = "empty"}, Trace{}), "empty");
  for (const char* column : {"tool.depth_m", "tool.force_n"}) { set(trace, column, std::nan("")); }
  CHECK_CONTAINS(to_html(RunReport{.title = "broken"}, trace), "Forces on the tool");
  trace = needle_trace();
  trace.time.resize(1);
  for (Column& column : trace.columns) { column.values.resize(1); }
  CHECK_CONTAINS(to_html(RunReport{.title = "short"}, trace), "short");
}

/// Box with half sides 3, 4 and 10 N; its corners are in random order.
FalconFacts box() {
  FalconFacts facts{.weakest_force = 3.0, .axial_force = 10.0};
  for (unsigned n = 0; n < 8; ++n) {
    const auto side = [corner = 5 * n](unsigned bit, double half) {
      return (corner & bit) != 0U ? half : -half;
    };
    facts.force_reach.emplace_back(side(1, 3.0), side(2, 4.0), side(4, 10.0));
  }
  return facts;
}

/// Shoelace formula.
double area_of(const Series& outline) {
  double twice = 0.0;
  for (std::size_t n = 1; n < outline.x.size(); ++n) {
    twice += outline.x[n - 1] * outline.y[n] - outline.x[n] * outline.y[n - 1];
  }
  return 0.5 * twice;
}

TEST("the reach of the motors is drawn as closed outlines of the box seen from two sides") {
  const Figure figure = force_reach_figure(box());
  CHECK(figure.square);
  REQUIRE(figure.series.size() == 4);
  const double areas[] = {4.0 * 3.0 * 10.0, 4.0 * 4.0 * 10.0};
  for (std::size_t side = 0; side < 2; ++side) {
    const Series& outline = figure.series[side];
    REQUIRE(outline.x.size() == 5);  // four corners, and the first again
    CHECK(outline.x.front() == outline.x.back());
    CHECK(outline.y.front() == outline.y.back());
    CHECK_NEAR(area_of(outline), areas[side], 1e-12);
  }
  // The force available in every direction is a circle. All series lie within the axes.
  const Series& circle = figure.series[2];
  for (std::size_t n = 0; n < circle.x.size(); ++n) {
    CHECK_NEAR(std::hypot(circle.x[n], circle.y[n]), 3.0, 1e-12);
  }
  for (const Series& series : figure.series) {
    for (std::size_t n = 0; n < series.x.size(); ++n) {
      CHECK(std::max(std::abs(series.x[n]), std::abs(series.y[n])) <= *figure.y.maximum);
    }
  }
}

TEST("a device that lost its position or its line is reported, and a sound one is not") {
  FalconFacts facts = box();
  facts.ticks = 1000;
  facts.saturated = 25;
  const std::vector<Fact> sound = falcon_fact_list(facts);
  CHECK(fact(sound, "ticks without a place") == nullptr);
  CHECK(fact(sound, "requests without reply") == nullptr);
  CHECK(required(sound, "motors at their limit").value == "2.5\u00a0%");
  facts.unhomed = 7;
  facts.unanswered = 9;
  CHECK(required(falcon_fact_list(facts), "ticks without a place").value == "7");
  CHECK(required(falcon_fact_list(facts), "requests without reply").value == "9");
}

}  // namespace PALPATE_FILE
