// SPDX-License-Identifier: MIT
#include "validation/comparison/samples.hpp"

#include "tests/check.hpp"

namespace {

using namespace palpate::comparison;

TEST("a straight line is the same line on any grid") {
  std::vector<double> time;
  std::vector<double> value;
  for (int n = 0; n < 50; ++n) {
    time.push_back(0.1 * n + (n % 2 == 0 ? 0.0 : 0.01));  // not uniform, within what is bridged
    value.push_back(3.0 * time.back() - 1.0);
  }
  const Samples moved = resample(time, value, {.start = 0.0, .step = 0.033, .count = 140});
  for (std::size_t n = 0; n < moved.size(); ++n) {
    CHECK_NEAR(moved.value[n], 3.0 * moved.time(n) - 1.0, 1e-12);
  }
}

TEST("samples on their own grid are those samples") {
  const std::vector<double> time{1.0, 1.25, 1.5, 1.75};
  const std::vector<double> value{4.0, not_measured, -2.0, 8.0};
  const Samples same = regular(time, value);
  CHECK(same.size() == 4 && same.start == 1.0 && same.step == 0.25);
  CHECK(same.value[0] == 4.0 && std::isnan(same.value[1]) && same.value[2] == -2.0 && same.value[3] == 8.0);
}

TEST("nothing is interpolated across a missing sample or one that is no number") {
  const std::vector<double> missing_time{0.0, 1.0, 2.0, 4.0, 5.0, 6.0};
  const std::vector<double> values{0.0, 1.0, 2.0, 4.0, 5.0, 6.0};
  const Grid grid{.start = 0.0, .step = 0.5, .count = 13};
  const Samples missing = resample(missing_time, values, grid);
  const std::vector<double> times{0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0};
  const std::vector<double> with_nan{0.0, 1.0, 2.0, not_measured, 4.0, 5.0, 6.0};
  const Samples nan = resample(times, with_nan, grid);
  for (const Samples& s : {missing, nan}) {
    CHECK(s.value[4] == 2.0 && s.value[8] == 4.0);
    for (const std::size_t n : {5UL, 6UL, 7UL}) { CHECK(std::isnan(s.value[n])); }
    CHECK(s.value[3] == 1.5 && s.value[9] == 4.5);
  }
}

TEST("an infinite sample is a gap") {
  const std::vector<double> time{0.0, 1.0, 2.0, 3.0};
  const std::vector<double> value{1.0, std::numeric_limits<double>::infinity(), 1.0, 1.0};
  const Samples s = regular(time, value);
  CHECK(s.value[0] == 1.0 && std::isnan(s.value[1]) && s.value[2] == 1.0);
}

TEST("nothing is made up before the first sample or after the last") {
  const std::vector<double> time{1.0, 2.0};
  const std::vector<double> value{5.0, 6.0};
  const Samples s = resample(time, value, {.start = 0.5, .step = 0.5, .count = 5});
  CHECK(std::isnan(s.value[0]) && s.value[1] == 5.0 && s.value[2] == 5.5 && s.value[3] == 6.0 &&
        std::isnan(s.value[4]));
  CHECK(std::isnan(resample(std::vector<double>{}, std::vector<double>{}, {.count = 1}).value[0]));
}

TEST("a grid between two times lies on its anchor") {
  const Grid grid = grid_between(0.24, 1.01, 0.1, 0.25);
  CHECK_NEAR(grid.start, 0.35, 1e-12);
  CHECK(grid.count == 3);
  CHECK(grid_between(1.0, 0.0, 0.0, 0.1).count == 0);
}

TEST("stretches end at gaps and the longest is the longest") {
  const std::vector<double> value{1.0, not_measured, 1.0, 1.0, not_measured, 1.0};
  const std::vector<Stretch> stretches = finite_stretches(value);
  CHECK(stretches.size() == 3 && stretches[1].begin == 2 && stretches[1].end == 4);
  CHECK(longest_stretch(value).begin == 2);
  CHECK(longest_stretch(std::vector<double>{}).size() == 0);
}

TEST("quantiles are linear between order statistics and skip gaps") {
  const std::vector<double> value{4.0, not_measured, 1.0, 3.0, 2.0};
  CHECK_NEAR(quantile(value, 0.5), 2.5, 1e-15);
  CHECK_NEAR(quantile(value, 1.0), 4.0, 0.0);
  CHECK_NEAR(quantile(value, 0.1), 1.3, 1e-15);
  CHECK(std::isnan(quantile(std::vector<double>{not_measured}, 0.5)));
}

}  // namespace
