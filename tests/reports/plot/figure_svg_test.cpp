// SPDX-License-Identifier: MIT

#include "reports/plot/figure_svg.hpp"

#include <cstdlib>

#include "reports/plot/figure_look.hpp"
#include "reports/plot/gnuplot.hpp"
#include "tests/check.hpp"
#include "tests/reports/sample_results.hpp"

using namespace palpate;

namespace {

bool contains(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST("a figure is one svg element that says what it shows and has no colour or id of its own") {
  const Figure figure = sample::curve();
  const std::string svg = draw_figures({&figure}).at(0);
  CHECK(svg.starts_with("<svg"));
  CHECK(svg.ends_with("</svg>"));
  CHECK(contains(svg,
                 "aria-label=\"Error &lt;over&gt; step &amp; &quot;more&quot;. The error falls"));
  CHECK(contains(svg, " s0\""));
  CHECK(contains(svg, " s1\""));
  for (const char* own : {"rgb(", "#0", " id=", "xmlns", "width=\"4", "black"}) {
    CHECK(!contains(svg, own));
  }
}

TEST("the same figures give the same bytes, alone or among others") {
  const Figure curve = sample::curve();
  const Figure map = sample::map();
  const std::vector<std::string> both = draw_figures({&curve, &map});
  CHECK(both == draw_figures({&curve, &map}));
  CHECK(both[1] == draw_figures({&map}).at(0));
}

TEST("a figure without a finite value, without series, or with one point is drawn as a frame") {
  Figure figure = sample::curve();
  for (Series& series : figure.series) { series.y.assign(series.y.size(), std::nan("")); }
  CHECK(draw_figures({&figure}).at(0).starts_with("<svg"));
  figure.series = {{.label = "one", .x = {1.0}, .y = {1.0}}};
  CHECK(draw_figures({&figure}).at(0).starts_with("<svg"));
  figure.series.clear();
  CHECK(draw_figures({&figure}).at(0).starts_with("<svg"));
  figure.heat_map = HeatMap{.x = {0.0, 1.0}, .y = {0.0, 1.0}, .z = {2.0, 2.0, 2.0, std::nan("")}};
  CHECK(draw_figures({&figure}).at(0).starts_with("<svg"));
}

TEST("labels are text: no markup and no command of gnuplot gets through") {
  Figure figure = sample::curve();
  figure.x.label = "a'\nset output '/tmp/x' <b> & `date` x^2_{y}";
  figure.series[0].label = "<script>";
  const std::string svg = draw_figures({&figure}).at(0);
  CHECK((contains(svg, "a&#39; set output") || contains(svg, "a' set output")));
  CHECK(contains(svg, "&lt;b> &amp; `date` x^2_{y}"));
  CHECK(contains(html_legend(figure), "&lt;script&gt;"));
  CHECK(!contains(html_legend(figure), "<script>"));
}

TEST("a long series keeps its spike when it is thinned") {
  Figure figure{.id = "long", .title = "long", .x = {.label = "t"}, .y = {.label = "y"}};
  Series series{.label = "spike"};
  for (int n = 0; n < 200000; ++n) {
    series.x.push_back(n);
    series.y.push_back(n == 123457 ? 1234.5 : 0.0);
  }
  figure.series = {series};
  const std::string script = gnuplot_script(figure, "out.svg");
  CHECK(contains(script, "1234.5"));
  CHECK(script.size() < 50000);
}

TEST("a law takes the colour of its measurement where the two alternate, and only there") {
  const Series measured{.label = "m", .style = Series::Style::points};
  const Series law{.label = "l", .style = Series::Style::dashed};
  const std::vector<Look> pairs = looks_of({.series = {measured, law, measured, law}});
  CHECK(pairs[0].colour == pairs[1].colour);
  CHECK(pairs[2].colour == pairs[3].colour);
  CHECK(pairs[0].colour != pairs[2].colour);
  const std::vector<Look> mixed = looks_of({.series = {measured, measured, measured, law}});
  CHECK(mixed[2].colour != mixed[3].colour);
}

TEST("without gnuplot the error says what to do") {
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/nonexistent", 1);
  const Figure figure = sample::curve();
  CHECK_THROWS(draw_figures({&figure}), "gnuplot is not installed");
  setenv("PATH", path.c_str(), 1);
}

using namespace palpate;

TEST("a path keeps its points to a tenth, without drift") {
  SvgPath path;
  path.append("M10.00,20.00 L10.04,30.00 L10.08,40.00 L10.12,50.00 L11.12,50.00 ");
  CHECK(path.data() == "M10 20v10l.1 10v10h1");
  SvgPath gap;
  gap.append("M0.00,0.00 L1.00,-0.50 M3.00,3.00 L4.00,4.00 Z");
  CHECK(gap.data() == "M0 0l1-.5M3 3l1 1z");
}

TEST("strokes of one kind become one path, and series stay apart and in order") {
  const std::string svg = svg_for_page(
      "<svg viewBox=\"0 0 9 9\"><title>t</title><defs><path id='x' d='M1,1'/></defs>"
      "<g stroke-width=\"0.80\"><path stroke='rgb(  1,   2,   2)' d='M0,0 L1,0 '/></g>"
      "<g stroke-width=\"0.80\"><path stroke='rgb(  1,   2,   1)' d='M0,0 L2,0 '/></g>"
      "<g stroke-width=\"0.80\"><path stroke='rgb(  1,   2,   2)' d='M0,1 L1,1 '/></g>"
      "<g id=\"plot_plot_1\" ><title>s</title><g stroke-width=\"1.80\">"
      "<path stroke='rgb(  1,   2,  16)' d='M0,0 L3,0 '/></g></g></svg>",
      "label");
  CHECK(svg ==
        "<svg role=\"img\" viewBox=\"0 0 9 9\" aria-label=\"label\">"
        "<path class=\"l g\" stroke-width=\".8\" d=\"M0 0h1M0 1h1\"/>"
        "<path class=\"l k\" stroke-width=\".8\" d=\"M0 0h2\"/>"
        "<path class=\"l s0\" stroke-width=\"1.8\" d=\"M0 0h3\"/></svg>");
}

TEST("an exponent stays one, and a small tick label becomes one") {
  const auto text = [](const std::string& inner) {
    return svg_for_page(
        "<svg viewBox=\"0 0 9 9\"><g transform=\"translate(3.00,4.00)\" "
        "text-anchor=\"end\"><text>" +
            inner + "</text></g></svg>",
        "");
  };
  CHECK(text("<tspan font-family=\"sans-serif\" >10</tspan><tspan font-size=\"11.2\" "
             "dy=\"-7.00px\">−2</tspan>"
             "<tspan font-size=\"14.0\" dy=\"7.00\"></tspan>")
            .find("<text x=\"3\" y=\"4\" text-anchor=\"end\">10<tspan class=\"up\" "
                  "dy=\"-5\">−2</tspan></text>") != std::string::npos);
  CHECK(text("<tspan> −5e−05</tspan>")
            .find(">−5·10<tspan class=\"up\" dy=\"-5\">−5</tspan></text>") != std::string::npos);
}

using namespace palpate;

namespace {

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
  CHECK(tint != std::string::npos);
  CHECK(area != std::string::npos);
  CHECK(tint < grid);
  CHECK(svg.find("class=\"f zb\"") < grid);
  CHECK(grid < area);
}

TEST("stacked areas are filled stronger than a band, and their sum is a line in ink") {
  const Figure figure = sample::layered();
  const std::string svg = draw_figures({&figure}).at(0);
  CHECK(contains(svg, "class=\"f s0\" opacity=\".5\""));
  CHECK(contains(svg, "class=\"f s1\" opacity=\".5\""));
  CHECK(contains(svg, "class=\"l k\" stroke-width=\"1.7\""));
  const Figure curve = sample::curve();
  CHECK(contains(draw_figures({&curve}).at(0), "class=\"f s2\" opacity=\".2\""));
}

TEST("labels of zones stand on the picture, those of marks once each in the legend") {
  const Figure figure = sample::layered();
  const std::string svg = draw_figures({&figure}).at(0);
  const std::string legend = html_legend(figure);
  CHECK(contains(svg, "class=\"note\""));
  CHECK(contains(svg, ">skin &lt;1>"));
  CHECK(count(legend, "puncture &amp; more") == 1);
  CHECK(count(legend, "contact") == 1);
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
  CHECK(contains(script, "across"));
  CHECK(contains(script, "backwards"));
  CHECK(!contains(script, "before"));
  CHECK(!contains(script, "nowhere"));
  CHECK(!contains(script, "nan"));
  CHECK(count(script, "set object rectangle") == 2);
  CHECK(count(script, "set arrow") == 0);
  CHECK(draw_figures({&figure}).at(0).starts_with("<svg"));
}

TEST("the y axis leaves room for labels above what lies beneath them") {
  const Figure figure = sample::layered();
  const Range x = x_range(figure);
  const Range y = y_range(figure);
  const Range room = range_below_labels(figure, x, y);
  CHECK(room.high > 1.05 * y.high);
  CHECK(room.low == y.low);
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
