// SPDX-License-Identifier: MIT
#pragma once
/// Calibration with measured insertions of several conditions at once, and its prediction of
/// conditions and needles that were left out (docs/calibration.md).

#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "validation/calibration/calibration.hpp"
#include "validation/comparison/group_comparison.hpp"

namespace palpate::calibration {

/// Insertions under one condition, and the scene that simulates it.
struct Condition {
  std::string name{};
  Scene scene{};
  std::vector<Recording> recordings{};  ///< with force and depth
  bool fitted = true;                   ///< false: predicted only
};

/// Features of an insertion that are fitted, in the order of the observables of one condition.
inline constexpr std::array fitted_features{
    comparison::Feature::puncture_force,   comparison::Feature::puncture_depth,
    comparison::Feature::denting_exponent, comparison::Feature::force_left,
    comparison::Feature::largest_force,    comparison::Feature::relaxation,
    comparison::Feature::relaxation_time,  comparison::Feature::withdrawal_force,
    comparison::Feature::withdrawal_depth};

/// A condition simulated at the fit, and compared with its recordings as one group.
struct ConditionCheck {
  std::string name{};
  bool fitted = true;
  Scene scene{};  ///< with the values of the fit
  Trace simulated{};
  comparison::GroupComparison comparison{};  ///< with one group

  /// Returns the group; its features have the means and standard deviations of the recordings.
  [[nodiscard]] const comparison::GroupSummary& group() const { return comparison.groups.front(); }
};

/// Difference of a simulated feature from the recordings.
struct FeatureError {
  const comparison::FeatureSummary* feature = nullptr;
  /// Simulated value less the mean of the recordings, in their standard deviations; infinite if the
  /// simulation lacks the feature.
  double deviations = 0.0;
  [[nodiscard]] bool within() const { return std::abs(deviations) <= most_deviations; }

  static constexpr double most_deviations = 2.0;
};

/// Returns the judged features of a condition: those that are no event and that at least two
/// recordings have.
std::vector<FeatureError> judged_features(const ConditionCheck& condition);

/// Prediction of the recordings of one needle by a fit to the others.
struct LeftOutNeedle {
  std::string needle{};  ///< `subject` of its recordings
  bool converged = false;
  std::vector<ConditionCheck> conditions{};
};

struct InsertionFit {
  Fit fit{};
  std::vector<ConditionCheck> conditions{};  ///< in the order given
  std::vector<LeftOutNeedle> left_out{};     ///< empty with fewer than two needles
  std::vector<double> misfits{};             ///< of each start, in the order tried; inf: failed
  std::size_t simulations = 0;

  /// The verdict: the search converged, the recordings tell a parameter and none lies at a bound,
  /// every condition has a feature to judge, and each feature of each predicted condition lies
  /// within two standard deviations of its recordings; without predicted conditions, of each fitted
  /// one.
  [[nodiscard]] Outcome outcome() const;
};

/// Returns the fitted features of a force over depth and time; NaN where one is absent. Of a
/// simulated insertion without a puncture, force and depth of the puncture are those of the largest
/// force of the advance, so that a search has a slope.
Observation observed_features(const Recording& recording);
Observation simulated_features(const Trace& trace);

/// Returns the parameters of the materials of all fitted conditions. The first condition that has a
/// key gives its prior.
std::vector<Parameter> parameters_of(const std::vector<Condition>& conditions);

/// Returns the reason why a condition cannot be calibrated; empty if it can. It needs a needle on a
/// prescribed path through layers that is withdrawn, and recordings with force and depth.
std::string why_not_calibrated(const Condition& condition);

struct InsertionFitOptions {
  int jobs = 2;
  int starts = 1;  ///< the priors, then places half a spread away in each parameter
  const std::atomic<bool>* stop = nullptr;
  std::function<void(const std::string& stage)> progress{};
  std::function<Trace(const Scene&)> simulate{};  ///< replaces our model
};

/// Fits the parameters to the fitted conditions and predicts all. Rows are the mean features of a
/// condition; the uncertainty of each is the standard deviation over its recordings, over the
/// square root of the number of needles. Throws runtime_error if a scene cannot be simulated at
/// the tested values, and Interrupted on a stop.
InsertionFit fit_insertions(std::vector<Condition> conditions,
                            const std::vector<Parameter>& parameters,
                            const InsertionFitOptions& options = {});

}  // namespace palpate::calibration
