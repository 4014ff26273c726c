// SPDX-License-Identifier: MIT
#pragma once
/// Calibration of a scene with recordings, and checks of the fit: profile of the misfit and
/// prediction of groups that were left out.

#include <span>

#include "validation/calibration/fit.hpp"
#include "validation/outcome.hpp"

namespace palpate::calibration {

/// Misfit for values of one parameter around its fit, with the other constrained parameters fitted
/// again at each value.
struct Profile {
  std::size_t parameter = 0;  ///< index
  std::vector<double> value{};
  std::vector<double> growth{};  ///< of the sum of squares, priors included, over that of the fit
};
/// Profile of the constrained parameter with the largest posterior deviation relative to its prior
/// spread; empty if none is constrained.
Profile profile_of_worst(Forward& forward, const Fit& fit);

/// Prediction of one group by a fit to the others.
struct HeldOut {
  std::string group{};
  std::size_t subjects = 0;
  Pooled seen{};                 ///< observations of the group that was left out
  Observation predicted{};       ///< depth of loss corrected for the difference in body mass index
  double error_fitted = 0.0;     ///< relative root mean square over observables, fitted groups
  double error_predicted = 0.0;  ///< the same for the group that was left out
  bool converged = false;
};

/// Returns the names of the groups in the order of the recordings.
std::vector<std::string> groups_of(std::span<const ObservedRecording> subjects);

/// Fits the constrained parameters again without each group in turn; empty for fewer than two
/// groups.
std::vector<HeldOut> leave_groups_out(Forward& forward, const Fit& fit,
                                      std::span<const ObservedRecording> subjects,
                                      const SharedUncertainty& shared = {});

/// Returns the relative error of every observable that both have; NaN elsewhere.
Eigen::VectorXd relative_errors(const Observation& simulated, const Observation& seen);
double root_mean_square(const Eigen::VectorXd& values);  ///< of the finite values

struct CalibrationOptions {
  Coarsening coarsening{};
  SharedUncertainty shared{};
  int jobs = 2;
  const std::atomic<bool>* stop = nullptr;
  std::function<void(const char* stage)> progress{};
  Forward::Simulate simulate{};  ///< replaces the simulation, for planted faults
};

struct Calibration {
  Fit fit{};
  Profile profile{};
  std::vector<HeldOut> held_out{};
  Scene fitted{};       ///< the scene with the values of the fit
  Observation whole{};  ///< the fitted scene with its own block and step, until the run ends
  std::size_t simulations = 0;  ///< number of simulations of the coarser scene

  /// Largest change of an observable by the shortcuts, divided by its uncertainty.
  [[nodiscard]] double shortcut_cost() const;
  /// The verdict: the search converged, at least one parameter is constrained, none is at a bound,
  /// the misfit did not grow, and the shortcuts change each observable by less than its
  /// uncertainty.
  [[nodiscard]] Outcome outcome() const;
};

/// Calibrates a scene. Every recording must have observables (no refusal); `parameters` is a subset
/// of parameters_of(), possibly with changed priors. Throws runtime_error if the scene cannot be
/// simulated at the tested values, and Interrupted on a stop.
Calibration calibrate(const Scene& scene, const std::vector<Parameter>& parameters,
                      std::span<const ObservedRecording> recordings,
                      const CalibrationOptions& options = {});

}  // namespace palpate::calibration
