// SPDX-License-Identifier: MIT
#include "reports/figure_svg.hpp"

#include <cstdlib>

#include "reports/figure_look.hpp"
#include "reports/gnuplot_script.hpp"
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
  CHECK(svg.starts_with("<svg") && svg.ends_with("</svg>"));
  CHECK(contains(svg,
                 "aria-label=\"Error &lt;over&gt; step &amp; &quot;more&quot;. The error falls"));
  CHECK(contains(svg, " s0\"") && contains(svg, " s1\""));
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
  CHECK(contains(svg, "a&#39; set output") || contains(svg, "a' set output"));
  CHECK(contains(svg, "&lt;b> &amp; `date` x^2_{y}"));
  CHECK(contains(html_legend(figure), "&lt;script&gt;") &&
        !contains(html_legend(figure), "<script>"));
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
  CHECK(pairs[0].colour == pairs[1].colour && pairs[2].colour == pairs[3].colour);
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
