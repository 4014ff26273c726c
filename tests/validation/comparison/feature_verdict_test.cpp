// SPDX-License-Identifier: MIT
#include "validation/comparison/feature_verdict.hpp"

#include "tests/check.hpp"
#include "validation/cases/clinical_traces.hpp"

namespace {

using namespace palpate;
using namespace palpate::comparison;

/// Both sides with every feature at 100, except for the peak.
Comparison given(double recorded_peak, double simulated_peak) {
  Comparison comparison{.unit = "Pa"};
  for (Measured& m : comparison.recorded_features.all) { m.value = 100.0; }
  comparison.simulated_features = comparison.recorded_features;
  comparison.recorded_features.loss.peak = 100.0;
  comparison.recorded_features.loss.relative_drop = 0.5;
  comparison.recorded_features[Feature::peak].value = recorded_peak;
  comparison.simulated_features[Feature::peak].value = simulated_peak;
  return comparison;
}

FeatureVerdict verdict_on(Feature feature, const Comparison& comparison,
                          const ComparisonOptions& options = {}) {
  return judge_features(comparison, options)[static_cast<std::size_t>(feature)];
}

TEST("error, interval and uncertainty by hand") {
  ComparisonOptions options;
  options.uncertainties = {
      .zero = 30.0, .gain = 0.01, .numerical = 0.02, .input = 0.03, .coverage_factor = 2.0};
  Comparison comparison = given(10000.0, 10500.0);
  comparison.recorded_features[Feature::peak].uncertainty = 40.0;
  const FeatureVerdict peak = verdict_on(Feature::peak, comparison, options);
  CHECK_NEAR(peak.error, 500.0, 1e-9);
  CHECK_NEAR(peak.uncertainty.data, std::sqrt(40.0 * 40.0 + 30.0 * 30.0 + 100.0 * 100.0), 1e-9);
  CHECK_NEAR(peak.uncertainty.numerical, 210.0, 1e-9);
  CHECK_NEAR(peak.uncertainty.input, 315.0, 1e-9);
  CHECK_NEAR(peak.expanded, 2.0 * std::sqrt(12500.0 + 210.0 * 210.0 + 315.0 * 315.0), 1e-9);
  CHECK(peak.verdict == Verdict::not_distinguishable);  // 500 + 790 > 1015
}

TEST("an offset of the transducer moves peak and plateau, and cancels in a height and in times") {
  ComparisonOptions options;
  options.uncertainties = {.zero = 50.0, .gain = 0.0};
  const Features& recorded = given(100.0, 100.0).recorded_features;
  CHECK_NEAR(data_uncertainty(Feature::peak, recorded, options), 50.0, 1e-12);
  CHECK_NEAR(data_uncertainty(Feature::plateau, recorded, options), 50.0, 1e-12);
  CHECK_NEAR(data_uncertainty(Feature::drop_height, recorded, options), 0.0, 1e-12);
  CHECK_NEAR(data_uncertainty(Feature::drop_time, recorded, options), 0.0, 1e-12);
  // d (1 - plateau / peak) / d offset = relative_drop / peak, in size
  CHECK_NEAR(data_uncertainty(Feature::relative_drop, recorded, options), 50.0 * 0.5 / 100.0, 1e-12);
}

TEST("times of a recording are told on the simulation's clock") {
  Comparison comparison = given(100.0, 100.0);
  comparison.alignment = {.used = AlignmentRule::start, .lag = 30.0, .uncertainty = 0.1};
  const FeatureVerdict time = verdict_on(Feature::time_of_loss, comparison);
  CHECK_NEAR(*time.recorded.value, 70.0, 1e-12);
  CHECK_NEAR(time.error, 30.0, 1e-12);
  CHECK_NEAR(time.uncertainty.data, 0.1, 1e-12);
  CHECK(time.verdict == Verdict::differs);
}

TEST("times are not judged where depth or the event aligned the clocks") {
  Comparison comparison = given(100.0, 100.0);
  for (const AlignmentRule rule : {AlignmentRule::depth, AlignmentRule::event}) {
    comparison.alignment = {.used = rule, .how = "by something", .lag = 30.0};
    const FeatureVerdict time = verdict_on(Feature::time_of_loss, comparison);
    CHECK(time.verdict == Verdict::not_judged);
    CHECK(time.reason == (rule == AlignmentRule::depth ? "the clocks were aligned by the depth"
                                                       : "the clocks were aligned by the event"));
    CHECK_NEAR(time.error, 30.0, 1e-12);  // told, though not judged
  }
  CHECK(verdict_on(Feature::depth_of_loss, comparison).verdict == Verdict::agrees);
}

TEST("an event in one of them alone differs; one that cannot be decided is open") {
  Comparison comparison = given(100.0, 100.0);
  comparison.recorded_features[Feature::loss_of_resistance].value = 1.0;
  comparison.simulated_features[Feature::loss_of_resistance].value = 0.0;
  CHECK(verdict_on(Feature::loss_of_resistance, comparison).verdict == Verdict::differs);
  comparison.simulated_features[Feature::loss_of_resistance] = {.reason = "the trace ends"};
  const FeatureVerdict open = verdict_on(Feature::loss_of_resistance, comparison);
  CHECK(open.verdict == Verdict::not_distinguishable);
  CHECK(open.reason == "simulated: the trace ends");
}

TEST("a feature in neither that is no event is not judged and says why") {
  Comparison comparison = given(100.0, 100.0);
  comparison.recorded_features[Feature::depth_of_peak] = {.reason = "depth was not recorded"};
  comparison.simulated_features[Feature::depth_of_peak] = {.reason = "no column"};
  const FeatureVerdict depth = verdict_on(Feature::depth_of_peak, comparison);
  CHECK(depth.verdict == Verdict::not_judged);
  CHECK(depth.reason == "recorded: depth was not recorded; simulated: no column");
}

TEST("an event that neither trace decides is open") {
  Comparison comparison = given(100.0, 100.0);
  comparison.recorded_features[Feature::loss_of_resistance] = {.reason = "the trace ends"};
  comparison.simulated_features[Feature::loss_of_resistance] = {.reason = "the trace ends"};
  const FeatureVerdict both = verdict_on(Feature::loss_of_resistance, comparison);
  CHECK(both.verdict == Verdict::not_distinguishable && both.reason == "in neither: the trace ends");
  comparison.simulated_features[Feature::loss_of_resistance] = {.reason = "a gap"};
  CHECK(verdict_on(Feature::loss_of_resistance, comparison).reason ==
        "recorded: the trace ends; simulated: a gap");
}

}  // namespace
