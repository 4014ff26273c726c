// SPDX-License-Identifier: MIT

#include "reports/plot/trace_figures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate;

TEST("a curve of a long trace keeps its ends, its extremes and its gaps in a part of the memory") {
  Trace trace;
  Column force{.name = "tool.force_n", .unit = "N"};
  constexpr std::size_t rows = 300'000;
  for (std::size_t n = 0; n < rows; ++n) {
    trace.time.push_back(1e-3 * static_cast<double>(n));
    force.values.push_back(std::sin(1e-4 * static_cast<double>(n)));
  }
  force.values[123'456] = 7.0;
  force.values[200'001] = -8.0;
  force.values[250'000] = std::numeric_limits<double>::quiet_NaN();
  trace.columns.push_back(force);
  Figure figure;
  add_column(figure, trace, Over::time, "tool.force_n");
  const Series& series = figure.series.front();
  CHECK(series.x.size() == series.y.size());
  CHECK(series.x.size() < rows / 10);
  CHECK(std::ranges::is_sorted(series.x));
  CHECK(series.x.front() == trace.time.front());
  CHECK(series.x.back() == trace.time.back());
  const auto at = [&](std::size_t row) {
    return series.y[static_cast<std::size_t>(std::ranges::lower_bound(series.x, trace.time[row]) -
                                             series.x.begin())];
  };
  CHECK(at(123'456) == 7.0);
  CHECK(at(200'001) == -8.0);
  CHECK(std::isnan(at(250'000)));
}

TEST("a curve of a short trace keeps every row") {
  Trace trace;
  trace.time = {0.0, 0.1, 0.2};
  trace.columns.push_back({.name = "a.x_m", .unit = "m", .values = {1.0, 2.0, 1.0}});
  Figure figure;
  add_column(figure, trace, Over::time, "a.x_m", "a", 2.0);
  CHECK((figure.series.front().y == std::vector<double>{2.0, 4.0, 2.0}));
}

}  // namespace PALPATE_FILE
