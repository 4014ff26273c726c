// SPDX-License-Identifier: MIT
#include "validation/comparison/features.hpp"

#include "tests/check.hpp"
#include "validation/cases/clinical_traces.hpp"
#include "validation/comparison/prepared_trace.hpp"

namespace {

using namespace palpate;
using namespace palpate::comparison;
using clinical::PressureLaw;

struct Given {
  std::vector<double> time = clinical::instants(14.0, 200.0);
  std::vector<double> value{};
  std::vector<double> depth{};
  [[nodiscard]] Features found() const { return prepare({time, value, depth}, 20.0, {}).features; }
};

Given of(const PressureLaw& law) {
  Given given;
  given.value = clinical::pressures(law, given.time);
  return given;
}

TEST("depth is read at the instants of the events") {
  Given given = of({});
  for (const double t : given.time) { given.depth.push_back(0.002 * t); }
  const Features found = given.found();
  CHECK_NEAR(*found[Feature::depth_of_loss].value, 0.002 * *found[Feature::time_of_loss].value, 1e-12);
  CHECK_NEAR(*found[Feature::depth_of_peak].value, 0.002 * *found[Feature::time_of_peak].value, 1e-12);
}

TEST("the duration of an exponential fall is its constant times ln 9") {
  const Features found = of({}).found();
  CHECK_NEAR(*found[Feature::drop_time].value, 0.15 * std::log(9.0), 0.02 * 0.33);  // 2 % of the filter
}

TEST("without a loss of resistance its features are absent for that reason, and the peak is the trace's") {
  const Features found = of({.plateau = PressureLaw{}.peak}).found();
  CHECK(*found[Feature::loss_of_resistance].value == 0.0);
  for (const Feature feature : {Feature::drop_height, Feature::relative_drop, Feature::drop_time,
                                Feature::plateau, Feature::time_of_loss, Feature::depth_of_loss}) {
    CHECK(!found[feature].value);
    CHECK(found[feature].reason.starts_with(feature == Feature::depth_of_loss ? "depth"
                                                                              : "no loss of resistance"));
  }
  const double peak = 60.0 * pascals_per_mmhg;
  CHECK_NEAR(*found[Feature::peak].value, peak, 0.01 * peak);  // overshoot of the filter
}

TEST("a trace that ends too early has a drop but no verdict on its event") {
  Given given = of({});
  const std::size_t kept = 200 * 9;
  given.time.resize(kept);
  given.value.resize(kept);
  const Features found = given.found();
  CHECK(!found[Feature::loss_of_resistance].value);
  CHECK(found[Feature::loss_of_resistance].reason.find("the trace ends") != std::string::npos);
  CHECK(found[Feature::drop_time].value && found[Feature::plateau].value);
}

TEST("a gap over the fall hides its duration and nothing else") {
  Given given = of({});
  for (std::size_t n = 0; n < given.time.size(); ++n) {
    if (given.time[n] > 6.05 && given.time[n] < 6.25) { given.value[n] = not_measured; }
  }
  const Features found = given.found();
  CHECK(found.loss.found());
  CHECK(!found[Feature::drop_time].value && found[Feature::drop_time].reason == "a gap hides the fall");
  CHECK(found[Feature::peak].value && found[Feature::plateau].value);
}

TEST("without two seconds before the peak there is no slope") {
  const Features found = of({.rise = 0.5, .loss = 1.5}).found();
  CHECK(!found[Feature::slope_before].value);
  CHECK(found[Feature::slope_before].reason == "less than 2.1 s before the peak");
}

TEST("noise on samples is found to a tenth and makes every feature uncertain") {
  Given given = of({});
  const Features clean = given.found();
  device::Seeded seeded(9);
  clinical::add_noise(given.value, 100.0, seeded);
  const Features noisy = given.found();
  CHECK_NEAR(noisy.noise, 100.0, 10.0);  // a median of 2800 is known to 2 %
  for (const Feature feature : {Feature::peak, Feature::plateau, Feature::drop_time, Feature::slope_before}) {
    CHECK(noisy[feature].uncertainty > clean[feature].uncertainty);
  }
}

TEST("features have units of the trace, and every one a name of its own") {
  CHECK(unit_of(Feature::peak, "N") == "N" && unit_of(Feature::slope_before, "Pa") == "Pa/s");
  CHECK(unit_of(Feature::drop_time, "Pa") == "s" && unit_of(Feature::depth_of_loss, "Pa") == "m");
  for (std::size_t n = 1; n < feature_count; ++n) {
    CHECK(name_of(static_cast<Feature>(n)) != name_of(static_cast<Feature>(n - 1)));
  }
  CHECK(name_of(Feature::depth_of_loss) == "depth_of_loss" && name_of(Feature::drop_time) == "drop_time");
}

}  // namespace
