// SPDX-License-Identifier: MIT

#include "validation/statistics.hpp"

#include "tests/check.hpp"
#include "validation/outcome.hpp"

namespace {

using namespace palpate::comparison;

TEST("a largest value keeps a NaN wherever it is added") {
  const auto largest = [](std::initializer_list<double> values) {
    palpate::Largest found;
    for (const double value : values) { found.add(value); }
    return found.value();
  };
  CHECK(largest({-1.0}) == 0.0);
  CHECK(largest({-1.0, 2.0, 1.0}) == 2.0);
  CHECK(std::isnan(largest({2.0, std::nan("")})));
  CHECK(std::isnan(largest({2.0, std::nan(""), 3.0})));
  CHECK(std::isnan(largest({std::nan(""), 1.0})));
}

TEST("the interval of a share is that of Clopper and Pearson") {
  // (1 - p)^n = 0.025 at the upper end.
  const Interval none = share_interval(0, 60);
  CHECK(none.lower == 0.0);
  CHECK_NEAR(none.upper, 1.0 - std::pow(0.025, 1.0 / 60.0), 1e-12);
  const Interval all = share_interval(60, 60);
  CHECK(all.upper == 1.0);
  CHECK_NEAR(all.lower, std::pow(0.025, 1.0 / 60.0), 1e-12);
  const Interval half = share_interval(5, 10);  // tabulated: 0.1871 to 0.8129
  CHECK_NEAR(half.lower, 0.1871, 5e-5);
  CHECK_NEAR(half.upper, 0.8129, 5e-5);
  for (const std::size_t hits : {0UL, 1UL, 500UL, 999UL, 1000UL}) {
    const Interval interval = share_interval(hits, 1000);
    const double share = static_cast<double>(hits) / 1000.0;
    CHECK(interval.holds(share));
    // Normal approximation 1.96 sqrt(p (1 - p) / n), at most 0.031, and 3.7 / n at the ends.
    CHECK(interval.upper - interval.lower < 0.064);
  }
}

TEST("Student's factor is the one of the tables, and inverts its share") {
  CHECK_NEAR(student_factor(0.95, 2), 4.302653, 5e-7);  // tables
  CHECK_NEAR(student_factor(0.95, 9), 2.262157, 5e-7);
  CHECK_NEAR(student_share(student_factor(0.9, 7), 7), 0.9, 1e-12);
  // Coverage of a bootstrap of five, as in statistics.hpp. Student's t of four degrees of freedom
  // is within +-t with sqrt(c) (1 + (1 - c) / 2), c = t^2 / (4 + t^2).
  const double c = 1.959964 * 1.959964 * 0.8 / (4.0 + 1.959964 * 1.959964 * 0.8);
  CHECK_NEAR(student_share(1.959964 * std::sqrt(0.8), 4), std::sqrt(c) * (1.0 + 0.5 * (1.0 - c)),
             1e-12);
  CHECK_NEAR(student_share(1.959964 * std::sqrt(0.8), 4), 0.846, 5e-4);
  CHECK_NEAR(normal_above(1.959963985), 0.025, 1e-10);
  CHECK_NEAR(normal_above(0.0), 0.5, 1e-15);
}

TEST("counts outside an expected share are rare; mean and deviation are those by hand") {
  // 10 fair coins give 0 or 10 heads with probability 2/1024 = 0.00195, more than 0.001, so 1 more
  // must be allowed.
  CHECK_NEAR(expected_share(0.5, 10, 0.999).lower, 0.0, 0.0);
  CHECK_NEAR(expected_share(0.5, 10, 0.99).lower, 0.1, 1e-15);
  CHECK_NEAR(expected_share(0.5, 10, 0.99).upper, 0.9, 1e-15);
  const std::vector<double> value{2.0, 4.0, 9.0};
  CHECK_NEAR(mean_of(value), 5.0, 1e-15);
  CHECK_NEAR(deviation_of(value), std::sqrt(13.0), 1e-14);
  CHECK(std::isnan(deviation_of(std::vector<double>{1.0})));
}

TEST("a bootstrap is the same for one seed, lies within the values and is refused for two") {
  const std::vector<double> value{1.0, 2.13, 3.37, 3.71, 4.94, 5.59, 6.07, 8.11};
  const auto bounds = [&](std::uint64_t seed) {
    const auto interval = bootstrap_mean(value, {.seed = seed}).value();
    return std::pair(interval.lower, interval.upper);
  };
  CHECK(bounds(4) == bounds(4));
  CHECK(bounds(4) != bounds(5));
  const auto one = bootstrap_mean(value, {.seed = 4});
  REQUIRE(one);
  CHECK(one->lower >= 1.0);
  CHECK(one->upper <= 10.0);
  CHECK(one->holds(4.0));
  CHECK(!bootstrap_mean(std::vector<double>{1.0, 2.0}));
  const auto equal = bootstrap_mean(std::vector<double>{7.0, 7.0, 7.0});
  REQUIRE(equal);
  CHECK_NEAR(equal->lower, 7.0, 1e-12);
  CHECK_NEAR(equal->upper, 7.0, 1e-12);
}

}  // namespace
