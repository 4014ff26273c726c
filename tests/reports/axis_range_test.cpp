// SPDX-License-Identifier: MIT
#include "reports/axis_range.hpp"

#include <algorithm>

#include "tests/check.hpp"
#include "tests/reports/sample_results.hpp"

using namespace palpate;

namespace {

int labelled(const std::vector<Tick>& ticks) {
  return static_cast<int>(
      std::ranges::count_if(ticks, [](const Tick& t) { return !t.label.empty(); }));
}

}  // namespace

TEST("a logarithmic axis has two to ten labels inside its range, whatever it spans") {
  for (const double low : {1e-300, 3e-17, 0.04, 0.97, 1.0, 7.0, 123.0}) {
    for (const double ratio : {1.02, 1.5, 3.0, 12.0, 90.0, 1e3, 1e7, 1e20, 1e290}) {
      const Range range{low, low * ratio, false};
      const std::vector<Tick> ticks = logarithmic_ticks(range);
      CHECK(labelled(ticks) >= 2 && labelled(ticks) <= 10);
      for (const Tick& tick : ticks) { CHECK(tick.value >= range.low && tick.value <= range.high); }
    }
  }
}

TEST("values that cannot be drawn do not widen an axis") {
  Figure figure = sample::curve();
  figure.series[0].y[0] = -5.0;
  figure.series[0].y[1] = unbounded;
  const Range range = y_range(figure);
  CHECK(range.low > 0.0 && range.high < 10.0);
}

TEST("an axis without a value is empty") {
  CHECK(x_range(Figure{}).empty);
  CHECK(y_range(Figure{.series = {{.x = {1.0}, .y = {std::nan("")}}}}).empty);
}

TEST("the cells of a heat map are whole") {
  const Figure figure = sample::map();             // centres from 0 to 2.75 in steps of 0.25
  CHECK_NEAR(x_range(figure).low, -0.125, 1e-12);  // rounding of a sum
  CHECK_NEAR(x_range(figure).high, 2.875, 1e-12);
}
