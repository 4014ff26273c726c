// SPDX-License-Identifier: MIT
#include "validation/comparison/feature_verdict.hpp"

#include <cmath>

namespace palpate::comparison {

namespace {

/// Whether a factor on the trace scales the feature, and whether an offset of the trace moves it.
bool scales(Feature feature) {
  return feature == Feature::peak || feature == Feature::plateau || feature == Feature::drop_height ||
         feature == Feature::slope_before;
}

/// Change of the feature per unit of offset of the trace.
double moved_by_offset(Feature feature, const Features& features) {
  if (feature == Feature::peak || feature == Feature::plateau) { return 1.0; }
  if (feature == Feature::relative_drop) { return features.loss.relative_drop / features.loss.peak; }
  return 0.0;
}

ValidationUncertainty uncertainty_of(const FeatureVerdict& one, const Comparison& comparison,
                                     const ComparisonOptions& options) {
  const double size = std::abs(*one.simulated.value);
  const bool by_model = scales(one.feature);
  const double lag = is_time(one.feature) ? comparison.alignment.uncertainty : 0.0;
  return {.numerical =
              std::hypot(one.simulated.uncertainty, by_model ? options.uncertainties.numerical * size : 0.0),
          .input = by_model ? options.uncertainties.input * size : 0.0,
          .data = std::hypot(data_uncertainty(one.feature, comparison.recorded_features, options), lag)};
}

void judge_numbers(FeatureVerdict& one, const Comparison& comparison, const ComparisonOptions& options) {
  const double recorded = *one.recorded.value;
  one.error = *one.simulated.value - recorded;
  one.lower = one.tolerance.lower(recorded);
  one.upper = one.tolerance.upper(recorded);
  one.uncertainty = uncertainty_of(one, comparison, options);
  one.expanded = options.uncertainties.coverage_factor * one.uncertainty.total();
  one.below_uncertainty = std::abs(one.error) < one.uncertainty.total();
  one.verdict = judge(*one.simulated.value, one.lower, one.upper, one.expanded);
}

std::string reason_of_absence(const FeatureVerdict& one) {
  if (one.recorded.value) { return "simulated: " + one.simulated.reason; }
  if (one.simulated.value) { return "recorded: " + one.recorded.reason; }
  if (one.recorded.reason == one.simulated.reason) { return "in neither: " + one.recorded.reason; }
  return "recorded: " + one.recorded.reason + "; simulated: " + one.simulated.reason;
}

/// One of the two is missing, or both. Only the event is never just absent: it is there, or it is not, or
/// nobody can tell; what is missing with it is told by the event itself.
void judge_absence(FeatureVerdict& one) {
  one.reason = reason_of_absence(one);
  one.verdict =
      one.feature == Feature::loss_of_resistance ? Verdict::not_distinguishable : Verdict::not_judged;
}

FeatureVerdict judge_feature(Feature feature, const Comparison& comparison,
                             const ComparisonOptions& options) {
  FeatureVerdict one{.feature = feature,
                     .unit = unit_of(feature, comparison.unit),
                     .recorded = comparison.recorded_features[feature],
                     .simulated = comparison.simulated_features[feature],
                     .tolerance = tolerance_of(feature, options)};
  if (is_time(feature) && one.recorded.value) { *one.recorded.value -= comparison.alignment.lag; }
  if (is_time(feature) && !comparison.alignment.judges_times()) {
    one.reason = "the clocks were aligned by the " + std::string(name_of(comparison.alignment.used));
    if (one.recorded.value && one.simulated.value) { one.error = *one.simulated.value - *one.recorded.value; }
    return one;
  }
  if (one.recorded.value && one.simulated.value) {
    judge_numbers(one, comparison, options);
  } else {
    judge_absence(one);
  }
  return one;
}

}  // namespace

Tolerance tolerance_of(Feature feature, const ComparisonOptions& options) {
  for (const Tolerance& given : options.tolerances) {
    if (given.feature == feature) { return given; }
  }
  return default_tolerances(options.quantity)[static_cast<std::size_t>(feature)];
}

double data_uncertainty(Feature feature, const Features& recorded, const ComparisonOptions& options) {
  const Uncertainties& known = options.uncertainties;
  const Measured& measured = recorded[feature];
  const double zero = options.quantity == QuantityKind::pressure ? known.zero : known.zero_force;
  const double gain = scales(feature) ? known.gain * std::abs(measured.value.value_or(0.0)) : 0.0;
  return std::hypot(measured.uncertainty, std::hypot(moved_by_offset(feature, recorded) * zero, gain));
}

std::vector<FeatureVerdict> judge_features(const Comparison& comparison, const ComparisonOptions& options) {
  std::vector<FeatureVerdict> verdicts;
  for (std::size_t n = 0; n < feature_count; ++n) {
    verdicts.push_back(judge_feature(static_cast<Feature>(n), comparison, options));
  }
  return verdicts;
}

}  // namespace palpate::comparison
