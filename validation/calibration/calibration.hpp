// SPDX-License-Identifier: MIT
#pragma once
/// Calibration of a scene with recordings, and checks of the fit: growth of the misfit away from
/// it, and prediction of groups that were left out.

#include <span>

#include "validation/calibration/fit.hpp"
#include "validation/outcome.hpp"

namespace palpate::calibration {

/// Least misfit with one parameter fixed beside its fit and the other constrained ones fitted
/// again.
struct Profile {
  std::size_t parameter = 0;  ///< index
  std::vector<double> value{};
  std::vector<double> growth{};  ///< of the sum of squares over that of the fit, priors included
};
/// Profile of the constrained parameter with the widest interval; empty if none is constrained.
Profile profile_of_worst(Forward& forward, const Fit& fit);

/// Prediction of one group by a fit to the others.
struct HeldOut {
  std::string group{};
  std::size_t subjects = 0;
  Pooled seen{};  ///< observations of the group that was left out
  Observation foretold{};
  double error_fitted = 0.0;    ///< root mean square over observables, relative, of those fitted
  double error_foretold = 0.0;  ///< the same of the group that was left out
  bool converged = false;
};

/// Names of the groups, in the order of the recordings.
std::vector<std::string> groups_of(std::span<const Subject> subjects);

/// Fits the constrained parameters again without each group in turn; empty for fewer than two
/// groups.
std::vector<HeldOut> leave_groups_out(Forward& forward, const Fit& fit,
                                      std::span<const Subject> subjects,
                                      const SharedUncertainty& shared = {});

/// Relative error of every observable that both have; NaN elsewhere.
Eigen::VectorXd relative_errors(const Observation& simulated, const Observation& seen);
double root_mean_square(const Eigen::VectorXd& values);  ///< of the numbers among them

// `palpate calibrate` without its files: from subjects and a scene to a fit and its checks.

struct CalibrationOptions {
  Coarsening coarsening{};
  SharedUncertainty shared{};
  int jobs = 2;
  const std::atomic<bool>* stop = nullptr;
  std::function<void(const char* stage)> progress{};
  Forward::Simulate simulate{};  ///< instead of the simulation: for planted faults
};

struct Calibration {
  Fit fit{};
  Profile profile{};
  std::vector<HeldOut> held_out{};
  Scene fitted{};               ///< the scene with the values of the fit
  Observation whole{};          ///< the fitted scene simulated as it is, without shortcuts
  std::size_t simulations = 0;  ///< of the coarser scene

  /// Largest difference between coarser and whole scene, in uncertainties of the data.
  [[nodiscard]] double shortcut_cost() const;
  /// The verdict: the search converged, at least one parameter is constrained, none is at a bound,
  /// the misfit did not grow, and the shortcuts change each observable by less than its
  /// uncertainty.
  [[nodiscard]] Outcome outcome() const;
};

/// Recordings without a refusal; parameters of parameters_of(), changed or fewer. Throws
/// runtime_error where the scene cannot be simulated at the values that are tried, Interrupted on a
/// stop.
Calibration calibrate(const Scene& scene, const std::vector<Parameter>& parameters,
                      std::span<const Subject> recordings, const CalibrationOptions& options = {});

}  // namespace palpate::calibration
