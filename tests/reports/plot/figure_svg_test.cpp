// SPDX-License-Identifier: MIT

#include "reports/plot/figure_svg.hpp"

#include <cstdlib>

#include "tests/check.hpp"
#include "tests/reports/sample_results.hpp"

namespace PALPATE_FILE {

using namespace palpate;

std::string drawn(const Figure& figure) { return draw_figures({&figure}).at(0); }

TEST("a figure is one svg element that says what it shows and has no colour or id of its own") {
  const Figure figure = sample::curve();
  const std::string svg = drawn(figure);
  CHECK(svg.starts_with("<svg"));
  CHECK(svg.ends_with("</svg>"));
  CHECK_CONTAINS(svg,
                 "aria-label=\"Error &lt;over&gt; step &amp; &quot;more&quot;. The error falls",
                 " s0\"", " s1\"");
  CHECK_LACKS(svg, "rgb(", "#0", " id=", "xmlns", "width=\"4", "black");
}

TEST("the same figures give the same bytes, alone or among others") {
  const Figure curve = sample::curve();
  const Figure map = sample::map();
  const std::vector<std::string> both = draw_figures({&curve, &map});
  CHECK(both == draw_figures({&curve, &map}));
  CHECK(both[1] == drawn(map));
}

TEST("a figure without a finite value, without series, or with one point is drawn as a frame") {
  Figure figure = sample::curve();
  Figure layered = sample::layered();
  for (Figure* each : {&figure, &layered}) {
    for (Series& series : each->series) { series.y.assign(series.y.size(), std::nan("")); }
    CHECK(drawn(*each).starts_with("<svg"));
    each->series.clear();
    CHECK(drawn(*each).starts_with("<svg"));
  }
  figure.heat_map = HeatMap{.x = {0.0, 1.0}, .y = {0.0, 1.0}, .z = {2.0, 2.0, 2.0, std::nan("")}};
  CHECK(drawn(figure).starts_with("<svg"));
  figure = sample::curve();
  figure.series = {{.label = "one", .x = {1.0}, .y = {1.0}}};
  CHECK(drawn(figure).starts_with("<svg"));
}

TEST("logarithmic axes have no equal scales") {
  Figure figure = sample::curve();
  figure.x.logarithmic = figure.y.logarithmic = true;
  const std::string svg = drawn(figure);
  figure.square = true;
  CHECK(drawn(figure) == svg);
}

TEST("labels are text, not markup") {
  Figure figure = sample::curve();
  figure.x.label = "a' <b> & x^2_{y}";
  figure.series[0].label = "<script>";
  const std::string svg = drawn(figure);
  CHECK_CONTAINS(svg, ">a&#39; &lt;b&gt; &amp; x^2_{y}</text>");
  CHECK_CONTAINS(html_legend(figure), "&lt;script&gt;");
  CHECK_LACKS(html_legend(figure), "<script>");
}

TEST("a long series keeps its spike when it is thinned") {
  Figure figure{.id = "long", .title = "long", .x = {.label = "t"}, .y = {.label = "y"}};
  Series series{.label = "spike"};
  for (int n = 0; n < 200000; ++n) {
    series.x.push_back(n);
    series.y.push_back(n == 123457 ? 1234.5 : 0.0);
  }
  figure.series = {series};
  const std::string svg = drawn(figure);
  const std::string path = svg.substr(svg.find("class=\"l s0\""));
  double highest_step = 0.0;  // upwards, which is negative
  for (std::size_t at = path.find('-'); at < path.find("/>"); at = path.find('-', at + 1)) {
    highest_step = std::min(highest_step, std::strtod(path.c_str() + at, nullptr));
  }
  CHECK(highest_step < -150.0);  // most of the height of the plot, in one step
  CHECK(svg.size() < 50000);
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

TEST("a path keeps its points to a tenth, without drift") {
  SvgPath path;
  path.move(10.0, 20.0);
  for (int n = 1; n < 4; ++n) { path.line(10.0 + 0.04 * n, 20.0 + 10.0 * n); }
  path.line(11.12, 50.0);
  path.close();
  CHECK(path.data() == "M10 20v10l.1 10v10h1z");
}

TEST("a layered figure has tints beneath the grid, areas above it, and escaped labels once each") {
  const Figure figure = sample::layered();
  const std::string svg = drawn(figure);
  CHECK_ORDER(svg, "class=\"f za\"", "class=\"f zb\"", "class=\"l g\"", "class=\"f s0\"");
  // Stacked areas are filled stronger than a band, and their sum is a line in ink.
  CHECK_CONTAINS(svg, "class=\"f s0\" opacity=\".5\"", "class=\"f s1\" opacity=\".5\"",
                 "class=\"l k\" stroke-width=\"1.7\"", "class=\"note\"", ">skin &lt;1&gt;");
  CHECK_LACKS(svg, "skin <1>");
  CHECK_CONTAINS(drawn(sample::curve()), "class=\"f s2\" opacity=\".2\"");
  const std::string legend = html_legend(figure);
  CHECK(check::count(legend, "puncture &amp; more") == 1);
  CHECK(check::count(legend, "contact") == 1);
  CHECK(check::count(legend, "<li>") == 3 + 2);
}

TEST("zones and marks outside the axis, turned round or not numbers are left out or cut") {
  Figure figure = sample::layered();
  figure.zones = {{"before", -5.0, -1.0},
                  {"across", -5.0, 2.0},
                  {"backwards", 6.0, 3.0},
                  {"nowhere", std::nan(""), 2.0}};
  figure.marks = {{"far", 99.0}, {"nowhere", std::nan("")}};
  const std::string svg = drawn(figure);
  CHECK_CONTAINS(svg, ">across<", ">backwards<");
  CHECK_LACKS(svg, "before", "nowhere", "nan");
  CHECK(check::count(svg, "class=\"f z") == 2);  // neighbours, so one of each tint
  CHECK(check::count(svg, "class=\"l n\"") == 0);
}

TEST("the y axis leaves room for labels unless it has a maximum, which clips what exceeds it") {
  Figure figure = sample::layered();
  // The largest value is 5; its tick label is at the top of the plot only if 5 is the limit.
  const std::string at_top = "y=\"21.6\" text-anchor=\"end\">5</text>";
  CHECK_LACKS(drawn(figure), at_top, "<svg x=");
  figure.y.maximum = 5.0;
  CHECK_CONTAINS(drawn(figure), at_top);
  figure.y.maximum = 3.0;
  CHECK(check::count(drawn(figure), "<svg x=") == 1);
}

TEST("a heat map is one image, with its colour bar beside it") {
  const std::string svg = drawn(sample::map());
  CHECK(check::count(svg, "<image") == 2);
  CHECK(check::count(svg, "data:image/png;base64,iVBORw0KGgo") == 2);
  CHECK_CONTAINS(svg, ">log10 growth</text>");
}

TEST("values of any size and spread are drawn with finite coordinates") {
  for (const double size : {0.0, 1e-300, 1e-12, 1.0, 1e17, 1e307}) {
    for (const double spread : {0.0, 1e-16, 1e-9, 1.0}) {
      for (const bool square : {false, true}) {
        Figure figure{.series = {{.x = {0.0, 1.0}, .y = {size, size * (1.0 + spread)}}}};
        figure.square = square;
        const std::string svg = drawn(figure);
        CHECK_LACKS(svg, "nan", "inf");
        CHECK(svg.size() < 5000);
      }
    }
  }
}

TEST("zones and marks follow the axis into another unit") {
  Figure figure = sample::layered();
  figure.x.label = "depth (m)";
  for (Series& series : figure.series) {
    for (double& x : series.x) { x *= 1e-3; }
  }
  for (Zone& zone : figure.zones) { zone.begin *= 1e-3, zone.end *= 1e-3; }
  for (Mark& mark : figure.marks) { mark.x *= 1e-3; }
  const auto without_texts = [](const std::string& svg) {
    return svg.substr(0, svg.find("<text"));
  };
  CHECK(without_texts(drawn(figure)) == without_texts(drawn(sample::layered())));
}

}  // namespace PALPATE_FILE
