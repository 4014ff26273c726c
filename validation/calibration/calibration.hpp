// SPDX-License-Identifier: MIT
#pragma once
/// What a fit is worth beyond its own recordings: how the misfit grows away from it, and how well
/// subjects are foretold that it has not seen.

#include <span>

#include "validation/calibration/fit.hpp"

namespace palpate::calibration {

/// Least misfit where one parameter is held beside its fit, all others told fitted again.
struct Profile {
  std::size_t parameter = 0;  ///< index
  std::vector<double> value{};
  std::vector<double> growth{};  ///< of the sum of squares over that of the fit, priors included
};
/// Of the parameter that is told with the widest interval; empty when none is.
Profile profile_of_worst(Forward& forward, const Fit& fit);

/// One group held out: the others fitted, the held-out one foretold.
struct HeldOut {
  std::string group{};
  std::size_t subjects = 0;
  Pooled seen{};  ///< of the group that was held out
  Observation foretold{};
  double error_fitted = 0.0;    ///< root mean square over observables, relative, of those fitted
  double error_foretold = 0.0;  ///< the same of the group that was held out
  bool converged = false;
};

/// Names of the groups, in the order of the recordings.
std::vector<std::string> groups_of(std::span<const Subject> subjects);

/// What was told is fitted again to all groups but one, for each; empty for fewer than two groups.
std::vector<HeldOut> leave_groups_out(Forward& forward, const Fit& fit,
                                      std::span<const Subject> subjects,
                                      const SharedUncertainty& shared = {});

/// Relative error of every observable that both have; NaN elsewhere.
Eigen::VectorXd relative_errors(const Observation& simulated, const Observation& seen);
double root_mean_square(const Eigen::VectorXd& values);  ///< of the numbers among them

// The whole of `palpate calibrate` but for files: subjects and a scene to a fit, what it is worth,
// and what its shortcuts cost.

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
  /// Converged, something told, nothing at a bound, nearer to the recordings than before, and
  /// shortcuts that cost less than the uncertainty of any observable.
  [[nodiscard]] bool held() const;
};

/// Recordings without a refusal; parameters of parameters_of(), changed or fewer. Throws
/// runtime_error where the scene cannot be simulated at the values that are tried, Interrupted on a
/// stop.
Calibration calibrate(const Scene& scene, const std::vector<Parameter>& parameters,
                      std::span<const Subject> recordings, const CalibrationOptions& options = {});

}  // namespace palpate::calibration
