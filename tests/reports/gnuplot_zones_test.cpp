// SPDX-License-Identifier: MIT
#include "reports/gnuplot_zones.hpp"

#include "reports/figure_svg.hpp"
#include "reports/gnuplot_script.hpp"
#include "tests/check.hpp"
#include "tests/reports/sample_results.hpp"

using namespace palpate;

namespace {

bool contains(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; ++at) { ++found; }
  return found;
}

}  // namespace

TEST("tints lie beneath the grid, and the grid beneath the curves") {
  const Figure figure = sample::layered();
  const std::string svg = draw_figures({&figure}).at(0);
  const std::size_t tint = svg.find("class=\"f za\"");
  const std::size_t grid = svg.find("class=\"l g\"");
  const std::size_t area = svg.find("class=\"f s0\"");
  CHECK(tint != std::string::npos && area != std::string::npos);
  CHECK(tint < grid && svg.find("class=\"f zb\"") < grid && grid < area);
}

TEST("stacked areas are filled stronger than a band, and their sum is a line in ink") {
  const Figure figure = sample::layered();
  const std::string svg = draw_figures({&figure}).at(0);
  CHECK(contains(svg, "class=\"f s0\" opacity=\".5\"") &&
        contains(svg, "class=\"f s1\" opacity=\".5\""));
  CHECK(contains(svg, "class=\"l k\" stroke-width=\"1.7\""));
  const Figure curve = sample::curve();
  CHECK(contains(draw_figures({&curve}).at(0), "class=\"f s2\" opacity=\".2\""));
}

TEST("labels of zones stand on the picture, those of marks once each in the legend") {
  const Figure figure = sample::layered();
  const std::string svg = draw_figures({&figure}).at(0);
  const std::string legend = html_legend(figure);
  CHECK(contains(svg, "class=\"note\"") && contains(svg, ">skin &lt;1>"));
  CHECK(count(legend, "puncture &amp; more") == 1 && count(legend, "contact") == 1);
  CHECK(count(legend, "<li>") == 3 + 2);
  CHECK(!contains(svg, "skin <1>"));
}

TEST("a label is text: no command of gnuplot gets through") {
  Figure figure = sample::layered();
  for (const char* label : {"'a'\nset output '/tmp/x'", "`date` $x @x", "\"q\" \\x ^2_{y}"}) {
    figure.zones[1].label = label;
    figure.zones[1].end = 1000.0;
    CHECK(draw_figures({&figure}).at(0).starts_with("<svg"));
  }
  figure.zones[1].label = "'`date`' \\\"@x";
  CHECK(contains(draw_figures({&figure}).at(0), ">'`date`' \\\"@x</text>"));
}

TEST("zones and marks outside the axis, turned round or not numbers are left out or cut") {
  Figure figure = sample::layered();
  figure.zones = {{"before", -5.0, -1.0},
                  {"across", -5.0, 2.0},
                  {"backwards", 6.0, 3.0},
                  {"nowhere", std::nan(""), 2.0}};
  figure.marks = {{"far", 99.0}, {"nowhere", std::nan("")}};
  const std::string script = gnuplot_script(figure, "out.svg");
  CHECK(contains(script, "across") && contains(script, "backwards"));
  CHECK(!contains(script, "before") && !contains(script, "nowhere") && !contains(script, "nan"));
  CHECK(count(script, "set object rectangle") == 2 && count(script, "set arrow") == 0);
  CHECK(draw_figures({&figure}).at(0).starts_with("<svg"));
}

TEST("the y axis leaves room for labels above what lies beneath them") {
  const Figure figure = sample::layered();
  const Range x = x_range(figure);
  const Range y = y_range(figure);
  const Range room = range_below_labels(figure, x, y);
  CHECK(room.high > 1.05 * y.high && room.low == y.low);
  Figure limited = figure;
  limited.y.maximum = 7.0;
  CHECK(range_below_labels(limited, x, y_range(limited)).high == 7.0);
}

TEST("a figure with zones but without a finite value is drawn as a frame") {
  Figure figure = sample::layered();
  for (Series& series : figure.series) { series.y.assign(series.y.size(), std::nan("")); }
  CHECK(draw_figures({&figure}).at(0).starts_with("<svg"));
  figure.series.clear();
  CHECK(draw_figures({&figure}).at(0).starts_with("<svg"));
}

TEST("zones and marks follow the axis into another unit") {
  Figure figure = sample::layered();
  figure.x.label = "depth (m)";
  for (Series& series : figure.series) {
    for (double& x : series.x) { x *= 1e-3; }
  }
  const std::string metres = gnuplot_script(sample::layered(), "out.svg");
  for (Zone& zone : figure.zones) { zone.begin *= 1e-3, zone.end *= 1e-3; }
  for (Mark& mark : figure.marks) { mark.x *= 1e-3; }
  std::string scaled = gnuplot_script(figure, "out.svg");
  const auto annotations = [](const std::string& script) {
    return script.substr(script.find("set object"), script.find("$s0") - script.find("set object"));
  };
  CHECK(annotations(metres) == annotations(scaled));
}
