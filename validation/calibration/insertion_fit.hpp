// SPDX-License-Identifier: MIT
#pragma once
/// Calibration with measured insertions of several conditions at once, and its prediction of
/// conditions and needles that were left out (docs/calibration.md).

#include <array>
#include <optional>
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
    comparison::Feature::relaxation_time,  comparison::Feature::withdrawal_force};

/// One feature of a condition: its mean and standard deviation over the recordings, and the
/// simulated value.
struct FeatureCheck {
  comparison::Feature feature{};
  std::size_t count = 0;
  double mean = comparison::not_measured;
  double deviation = comparison::not_measured;  ///< NaN for fewer than two recordings
  double before = comparison::not_measured;     ///< simulated at the priors
  double after = comparison::not_measured;      ///< simulated at the fit
  /// Returns (after - mean) / deviation.
  [[nodiscard]] double distance() const { return (after - mean) / deviation; }
};

/// One simulated condition after the fit.
struct ConditionCheck {
  std::string name{};
  bool fitted = true;
  std::size_t recordings = 0;
  Scene scene{};  ///< with the values of the fit
  std::vector<FeatureCheck> features{};
};

/// Prediction of the recordings of one subject (a needle) by a fit to the others.
struct LeftOutSubject {
  std::string subject{};
  bool converged = false;
  std::vector<ConditionCheck> conditions{};
};

struct InsertionFit {
  Fit fit{};
  std::vector<ConditionCheck> conditions{};  ///< in the order given
  std::vector<LeftOutSubject> left_out{};    ///< empty with fewer than two subjects
  std::size_t starts = 1;                    ///< number of searches; the best is the fit
  std::size_t simulations = 0;

  /// The verdict: the search converged, and each feature of each predicted condition lies within
  /// two standard deviations of its recordings; without predicted conditions, of each fitted one.
  [[nodiscard]] Outcome outcome() const;
};

/// Returns the features of a force over depth and time, in the order of fitted_features; NaN where
/// a feature is absent. Of a simulated insertion without a puncture the force and depth of the
/// puncture are those of the largest force, so that a search has a slope.
Observation observed_features(const Recording& recording);
Observation simulated_features(const Trace& trace);

/// Parameters of the materials of all conditions, without those of a syringe; the first condition
/// that has a key gives its prior.
std::vector<Parameter> parameters_of(const std::vector<Condition>& conditions);

/// Returns the reason why a condition cannot be calibrated; empty if it can. It needs a needle on a
/// prescribed path through layers that rests at its depth and is withdrawn, and recordings with
/// force and depth.
std::string why_not_calibrated(const Condition& condition);

struct InsertionFitOptions {
  int jobs = 2;
  int starts = 1;         ///< the priors, then other places half a prior spread away
  bool leave_out = true;  ///< fit again without each subject
  const std::atomic<bool>* stop = nullptr;
  std::function<void(const std::string& stage)> progress{};
  Forward::Simulate simulate{};  ///< replaces the simulation, for planted faults
};

/// Fits the parameters to the fitted conditions and predicts all. Rows are the mean features of a
/// condition; the uncertainty of each is the standard deviation over its recordings, over the
/// square root of the number of subjects. Throws runtime_error if a scene cannot be simulated at
/// the tested values, and Interrupted on a stop.
InsertionFit fit_insertions(const std::vector<Condition>& conditions,
                            const std::vector<Parameter>& parameters,
                            const InsertionFitOptions& options = {});

}  // namespace palpate::calibration
