// SPDX-License-Identifier: MIT

#include "validation/statistics.hpp"

#include "device/seeded.hpp"
#include "tests/check.hpp"
#include "validation/claims/clinical_fixture.hpp"
#include "validation/outcome.hpp"

namespace PALPATE_FILE {

using namespace palpate::comparison;
using namespace palpate;

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

TEST("equal codes are one subject, and each empty one is a subject of its own") {
  const std::vector<std::string> codes{"a", "", "b", "a", "", "b"};
  CHECK(subject_indices(codes) == std::vector<std::size_t>({0, 1, 2, 0, 3, 2}));
  CHECK(subject_count(subject_indices(codes)) == 4);
  CHECK(subject_count({}) == 0);
}

TEST("two recordings of each subject count once: means and spreads are those by hand") {
  // Means 2, 5, 11: mean 6, variance (16 + 1 + 25) / 2 = 21. Within: squares 2, 8, 2 over 3: 4.
  const std::vector<double> value{1.0, 3.0, 3.0, 7.0, 10.0, 12.0};
  const std::vector<std::size_t> subject{0, 0, 1, 1, 2, 2};
  const OverSubjects over = over_subjects(value, subject);
  CHECK(over.means.size() == 3);
  CHECK(over.recordings == 6);
  CHECK_NEAR(over.mean, 6.0, 1e-14);
  CHECK_NEAR(over.deviation, std::sqrt(21.0), 1e-14);
  CHECK_NEAR(over.of_recording, std::sqrt(21.0 + 4.0 * (1.0 - 0.5)), 1e-14);
}

TEST("a recording given twice changes nothing, NaN is left out, and one subject has no spread") {
  const std::vector<double> once{1.0, 3.0, 8.0};
  const std::vector<double> twice{1.0, 1.0, 3.0, 3.0, 8.0, 8.0, not_measured};
  const std::vector<std::size_t> subject{0, 0, 1, 1, 2, 2, 3};
  const OverSubjects a = over_subjects(once);
  const OverSubjects b = over_subjects(twice, subject);
  CHECK(a.means == b.means);
  CHECK(a.mean == b.mean);
  CHECK(a.deviation == b.deviation);
  CHECK_NEAR(b.of_recording, a.of_recording, 1e-15);
  // No subject and one subject have no spread.
  CHECK(std::isnan(over_subjects({}).mean));
  CHECK(std::isnan(over_subjects(std::vector<double>{4.0}).deviation));
  const std::vector<std::size_t> same{0, 0};
  CHECK(std::isnan(over_subjects(std::vector<double>{4.0, 5.0}, same).of_recording));
}

TEST("a single recording of a further subject lies in the corridor as often as it says, or more") {
  // Four subjects with two recordings each, B = W = 1: Student with 3 degrees of freedom is a
  // little too wide, as W is known from 4.
  constexpr std::size_t trials = 4000;
  device::Seeded seeded(5);
  const std::vector<std::size_t> subject{0, 0, 1, 1, 2, 2, 3, 3};
  std::size_t inside = 0;
  for (std::size_t n = 0; n < trials; ++n) {
    std::vector<Samples> all;
    for (std::size_t m = 0; m < 4; ++m) {
      const double own = seeded.normal();
      for (int repeat = 0; repeat < 2; ++repeat) {
        all.push_back({.value = {own + seeded.normal()}});
      }
    }
    const Samples further{.value = {seeded.normal() + seeded.normal()}};
    inside += coverage(*build_corridor(all, {}, subject).corridor, further).holds ? 1 : 0;
  }
  const double share = static_cast<double>(inside) / trials;
  CHECK(share >= expected_share(0.95, trials).lower);
}

Samples of(std::vector<double> value) { return {.step = 1.0, .value = std::move(value)}; }

TEST("fewer subjects than needed are refused with both numbers") {
  const std::vector<Samples> one{of({1.0})}, two{of({1.0}), of({2.0})};
  const std::vector<Samples> three{of({1.0}), of({2.0}), of({3.0})};
  const std::string refusal = "a corridor needs at least 3 subjects; there ";
  CHECK(!build_corridor(two).corridor);
  CHECK(build_corridor(two).refusal == refusal + "are 2");
  CHECK(build_corridor(one).refusal == refusal + "is 1");
  CHECK(build_corridor(three, {}, std::vector<std::size_t>{0, 0, 1}).refusal == refusal + "are 2");
  CHECK(!build_corridor({}).refusal.empty());
  CHECK(!build_corridor(one, {.least_subjects = 1}).corridor);
}

TEST("mean, deviation and width are those by hand, also where fewer subjects were measured") {
  const std::vector<Samples> three{of({2.0, 1.0}), of({4.0, 1.0}), of({9.0, 1.0})};
  const CorridorBuilt built = build_corridor(three);
  CHECK_NEAR(built.corridor->mean.value[0], 5.0, 1e-14);
  CHECK_NEAR(built.corridor->deviation.value[0], std::sqrt(13.0), 1e-14);
  CHECK_NEAR(built.corridor->factor, 4.302653 * std::sqrt(4.0 / 3.0), 1e-6);  // t(0.975, 2)
  CHECK_NEAR(built.corridor->half_width.value[0], 4.302653 * std::sqrt(4.0 / 3.0 * 13.0), 1e-5);
  CHECK_NEAR(build_corridor(three, {.half_width = 2.0}).corridor->factor, 2.0, 0.0);
  const std::vector<Samples> four{of({2.0, 2.0}), of({4.0, 4.0}), of({9.0, 9.0}),
                                  of({5.0, not_measured})};
  const SubjectCorridor corridor = *build_corridor(four).corridor;
  CHECK_NEAR(corridor.factor, 3.182446 * std::sqrt(5.0 / 4.0), 1e-6);  // t(0.975, 3)
  CHECK_NEAR(corridor.half_width.value[1], 4.302653 * std::sqrt(4.0 / 3.0 * 13.0), 1e-5);
}

TEST("samples inside are counted, the largest excursion is found, gaps are not judged") {
  std::vector<Samples> three;
  for (const double level : {-1.0, 0.0, 1.0}) { three.push_back(of({level, level, level, level})); }
  const CorridorRule rule{.half_width = 2.0};
  const CorridorBuilt built = build_corridor(three, rule);  // 0 +- 2
  const CorridorCoverage found =
      coverage(*built.corridor, of({2.0, -5.0, not_measured, 2.5}), rule);
  CHECK(found.samples == 3);
  CHECK_NEAR(found.inside, 1.0 / 3.0, 1e-15);
  CHECK_NEAR(found.largest_excursion, 3.0, 1e-15);
  CHECK_NEAR(found.excursion_time, 1.0, 0.0);
  CHECK(!found.holds);
  // The corridor ends when too few subjects were measured.
  const std::vector<Samples> ending{of({1.0, not_measured}), of({2.0, 2.0}), of({3.0, 3.0})};
  const CorridorBuilt short_one = build_corridor(ending);
  CHECK(std::isnan(short_one.corridor->mean.value[1]));
  const CorridorCoverage nothing = coverage(*short_one.corridor, of({not_measured, 2.0}));
  CHECK(nothing.samples == 0);
  CHECK(!nothing.holds);
  CHECK(std::isnan(nothing.inside));
}

}  // namespace PALPATE_FILE
