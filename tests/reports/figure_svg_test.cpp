// SPDX-License-Identifier: MIT
#include "reports/figure_svg.hpp"

#include "reports/gnuplot_script.hpp"
#include "tests/check.hpp"
#include "tests/reports/sample_results.hpp"

using namespace palpate;

TEST("a figure is one svg element that says what it shows and follows the page's colours") {
  const Figure figure = sample::curve();
  const std::string svg = draw_figures({&figure}).at(0);
  CHECK(svg.starts_with("<svg"));
  CHECK(svg.find("aria-label=\"Error &lt;over&gt; step &amp; &quot;more&quot;. The error falls") != std::string::npos);
  CHECK(svg.find("var(--series-0)") != std::string::npos);
  CHECK(svg.find("rgb(") == std::string::npos);
  CHECK(svg.find(" id=") == std::string::npos);
  CHECK(svg.find("measured_error^2") != std::string::npos);
}

TEST("a figure without a finite value, or without series, is drawn as an empty frame") {
  Figure figure = sample::curve();
  for (Series& series : figure.series) { series.y.assign(series.y.size(), std::nan("")); }
  CHECK(draw_figures({&figure}).at(0).starts_with("<svg"));
  figure.series.clear();
  CHECK(draw_figures({&figure}).at(0).starts_with("<svg"));
}

TEST("a long series keeps its extremes when it is thinned") {
  Figure figure{.id = "long", .title = "long", .x = {.label = "t"}, .y = {.label = "y"}};
  Series series{.label = "spike"};
  for (int n = 0; n < 200000; ++n) {
    series.x.push_back(n);
    series.y.push_back(n == 123457 ? 1234.5 : 0.0);
  }
  figure.series = {series};
  const std::string script = gnuplot_script(figure, "out.svg");
  CHECK(script.find("1234.5") != std::string::npos);
  CHECK(script.size() < 200000);
}
