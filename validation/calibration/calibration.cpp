// SPDX-License-Identifier: MIT
#include "validation/calibration/calibration.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::calibration {

double Calibration::shortcut_cost() const {
  double worst = 0.0;
  for (const Eigen::Index row : fit.rows) {
    const double difference =
        std::abs(whole[row] - fit.after[row]) / std::sqrt(fit.data.covariance(row, row));
    worst = difference > worst || std::isnan(difference) ? difference : worst;
  }
  return worst;
}

bool Calibration::held() const {
  const bool free = std::ranges::none_of(fit.parameters, &FittedParameter::at_bound);
  const bool nearer = fit.misfit_after <= fit.misfit_before;
  return fit.converged && !fit.told.empty() && free && nearer && shortcut_cost() < 1.0;
}

namespace {

/// The coarsest of three forms that the scene can be simulated in as it is.
Coarsening coarsest(const Scene& scene, const CalibrationOptions& options) {
  Coarsening gentler = options.coarsening;
  gentler.block = false;
  for (const Coarsening& how : {options.coarsening, gentler}) {
    const Scene coarse = coarser(scene, how);
    const ObservedInsertion seen =
        options.simulate ? options.simulate(coarse) : simulate_insertion(coarse, options.stop);
    if (seen.refusal.empty()) { return how; }
  }
  gentler.step_factor = 1.0;
  return gentler;
}

}  // namespace

Calibration calibrate(const Scene& scene, const std::vector<Parameter>& parameters,
                      std::span<const Subject> recordings, const CalibrationOptions& options) {
  const std::vector<Subject> subjects = by_person(recordings);
  const auto tell = [&](const char* stage) {
    if (options.progress) { options.progress(stage); }
  };
  Forward forward(coarser(scene, coarsest(scene, options)), parameters, options.jobs, options.stop,
                  options.simulate);
  Calibration result;
  tell("fitting");
  result.fit = fit(forward, pool(subjects, options.shared));
  tell("profile of the least certain parameter");
  result.profile = profile_of_worst(forward, result.fit);
  tell("leaving groups out");
  result.held_out = leave_groups_out(forward, result.fit, subjects, options.shared);
  tell("the fitted scene without shortcuts");
  result.fitted = with_values(scene, parameters, result.fit.values());
  const Coarsening none{.block = false, .step_factor = 1.0, .after = options.coarsening.after};
  Forward whole(coarser(result.fitted, none), {}, 1, options.stop, options.simulate);
  result.whole = whole.at(Forward::Values{});
  result.simulations = forward.simulations();
  return result;
}

}  // namespace palpate::calibration
