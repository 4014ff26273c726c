// SPDX-License-Identifier: MIT
#pragma once
/// The whole of `palpate calibrate` but for files: subjects and a scene to a fit, what it is worth, and what
/// its shortcuts cost.

#include "validation/calibration/cross_check.hpp"

namespace palpate::calibration {

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
  /// Converged, something told, nothing at a bound, nearer to the recordings than before, and shortcuts that
  /// cost less than the uncertainty of any observable.
  [[nodiscard]] bool held() const;
};

/// Recordings without a refusal; parameters of parameters_of(), changed or fewer. Throws runtime_error where
/// the scene cannot be simulated at the values that are tried, Interrupted on a stop.
Calibration calibrate(const Scene& scene, const std::vector<Parameter>& parameters,
                      std::span<const Subject> recordings, const CalibrationOptions& options = {});

}  // namespace palpate::calibration
