// SPDX-License-Identifier: MIT
#include "validation/comparison/subject_corridor.hpp"

#include "tests/check.hpp"

namespace {

using namespace palpate::comparison;

Samples of(std::vector<double> value) { return {.step = 1.0, .value = std::move(value)}; }

TEST("fewer subjects than needed are refused with both numbers") {
  const std::vector<Samples> two{of({1.0}), of({2.0})};
  const CorridorBuilt built = build_corridor(two);
  CHECK(!built.corridor);
  CHECK(built.refusal == "a corridor needs at least 3 subjects; there are 2");
  CHECK(build_corridor(std::vector<Samples>{two[0]}).refusal ==
        "a corridor needs at least 3 subjects; there is 1");
  CHECK(!build_corridor({}).refusal.empty());
}

TEST("one recording is refused whatever is asked for") {
  const std::vector<Samples> one{of({1.0})};
  CHECK(!build_corridor(one, {.least_subjects = 1}).corridor);
}

TEST("mean, deviation and width by hand") {
  const std::vector<Samples> three{of({2.0, 1.0}), of({4.0, 1.0}), of({9.0, 1.0})};
  const CorridorBuilt built = build_corridor(three);
  CHECK_NEAR(built.corridor->mean.value[0], 5.0, 1e-14);
  CHECK_NEAR(built.corridor->deviation.value[0], std::sqrt(13.0), 1e-14);
  CHECK_NEAR(built.corridor->factor, 4.302653 * std::sqrt(4.0 / 3.0), 1e-6);  // t(0.975, 2)
  CHECK_NEAR(built.corridor->half_width.value[0], 4.302653 * std::sqrt(4.0 / 3.0 * 13.0), 1e-5);
  CHECK_NEAR(build_corridor(three, {.half_width = 2.0}).corridor->factor, 2.0, 0.0);
}

TEST("samples inside are counted, the largest excursion is found, gaps are not judged") {
  const std::vector<Samples> three{of({-1.0, -1.0, -1.0, -1.0}), of({0.0, 0.0, 0.0, 0.0}),
                                   of({1.0, 1.0, 1.0, 1.0})};
  const CorridorRule rule{.half_width = 2.0};
  const CorridorBuilt built = build_corridor(three, rule);  // 0 +- 2
  const CorridorCoverage found = coverage(*built.corridor, of({2.0, -5.0, not_measured, 2.5}), rule);
  CHECK(found.samples == 3);
  CHECK_NEAR(found.inside, 1.0 / 3.0, 1e-15);
  CHECK_NEAR(found.largest_excursion, 3.0, 1e-15);
  CHECK_NEAR(found.excursion_time, 1.0, 0.0);
  CHECK(!found.holds);
}

TEST("where too few were measured there is no corridor, and nothing there is judged") {
  const std::vector<Samples> three{of({1.0, not_measured}), of({2.0, 2.0}), of({3.0, 3.0})};
  const CorridorBuilt built = build_corridor(three);
  CHECK(std::isnan(built.corridor->mean.value[1]));
  const CorridorCoverage found = coverage(*built.corridor, of({not_measured, 2.0}));
  CHECK(found.samples == 0 && !found.holds && std::isnan(found.inside));
}

TEST("where fewer subjects were measured the corridor has their factor") {
  const std::vector<Samples> four{of({2.0, 2.0}), of({4.0, 4.0}), of({9.0, 9.0}), of({5.0, not_measured})};
  const SubjectCorridor corridor = *build_corridor(four).corridor;
  CHECK_NEAR(corridor.factor, 3.182446 * std::sqrt(5.0 / 4.0), 1e-6);  // t(0.975, 3)
  CHECK_NEAR(corridor.half_width.value[1], 4.302653 * std::sqrt(4.0 / 3.0 * 13.0), 1e-5);
}

TEST("three recordings of two subjects are no three subjects") {
  const std::vector<Samples> three{of({1.0}), of({2.0}), of({3.0})};
  const std::vector<std::size_t> subject{0, 0, 1};
  CHECK(build_corridor(three, {}, subject).refusal == "a corridor needs at least 3 subjects; there are 2");
}

}  // namespace
