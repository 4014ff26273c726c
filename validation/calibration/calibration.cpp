// SPDX-License-Identifier: MIT

#include "validation/calibration/calibration.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::calibration {
namespace {

/// Corrects the depth of a group whose BMI differs from that of the fitted groups.
void move_depth(Observation& predicted, const Pooled& fitted, const Pooled& held) {
  if (!fitted.body_mass_index || !held.body_mass_index) { return; }
  predicted[index_of(Observable::depth_of_loss)] +=
      depth_per_body_mass_index * (*held.body_mass_index - *fitted.body_mass_index);
}

}  // namespace

Profile profile_of_worst(Forward& forward, const Fit& fit) {
  Profile profile;
  if (fit.told.empty()) { return profile; }
  profile.parameter = *std::ranges::max_element(
      fit.told, {}, [&](std::size_t n) { return fit.parameters[n].deviation; });
  const FittedParameter& worst = fit.parameters[profile.parameter];
  std::vector<std::size_t> others = fit.told;
  std::erase(others, profile.parameter);
  const double middle = worst.parameter.standardised(worst.value);
  const double lowest = worst.parameter.standardised(worst.parameter.lower);
  const double highest = worst.parameter.standardised(worst.parameter.upper);
  const Search search(forward, fit.data, others);
  const auto cost_at = [&](double x) {
    Forward::Values start = fit.values();
    start[profile.parameter] = worst.parameter.value(x);
    return search.from(start, {.most_iterations = 6}).cost + x * x;  // its own prior is a row too
  };
  const double least = cost_at(middle);
  for (const double deviations : {-1.0, -0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75, 1.0}) {
    const double x = middle + deviations * worst.deviation;
    if (x < lowest || x > highest) { continue; }
    profile.value.push_back(worst.parameter.value(x));
    profile.growth.push_back(cost_at(x) - least);
  }
  return profile;
}

std::vector<std::string> groups_of(std::span<const ObservedRecording> subjects) {
  std::vector<std::string> groups;
  for (const ObservedRecording& subject : subjects) {
    if (std::ranges::find(groups, subject.recording.group) == groups.end()) {
      groups.push_back(subject.recording.group);
    }
  }
  return groups;
}

std::vector<HeldOut> leave_groups_out(Forward& forward, const Fit& fit,
                                      std::span<const ObservedRecording> subjects,
                                      const SharedUncertainty& shared) {
  std::vector<HeldOut> all;
  const std::vector<std::string> groups = groups_of(subjects);
  if (groups.size() < 2) { return all; }
  for (const std::string& group : groups) {
    std::vector<ObservedRecording> held;
    std::vector<ObservedRecording> others;
    for (const ObservedRecording& subject : subjects) {
      (subject.recording.group == group ? held : others).push_back(subject);
    }
    const Pooled fitted = pool(others, shared);
    HeldOut out{.group = group, .subjects = held.size(), .seen = pool(held, shared)};
    const Search::Found found = Search(forward, fitted, fit.told).from(fit.values());
    out.converged = found.converged;
    out.predicted = forward.at(found.values);
    out.error_fitted = root_mean_square(relative_errors(out.predicted, fitted.mean));
    move_depth(out.predicted, fitted, out.seen);
    out.error_predicted = root_mean_square(relative_errors(out.predicted, out.seen.mean));
    all.push_back(std::move(out));
  }
  return all;
}

Eigen::VectorXd relative_errors(const Observation& simulated, const Observation& seen) {
  return (simulated - seen).cwiseQuotient(seen);
}

double root_mean_square(const Eigen::VectorXd& values) {
  double sum = 0.0;
  double count = 0.0;
  for (const double v : values) {
    if (std::isfinite(v)) { sum += v * v, count += 1.0; }
  }
  return std::sqrt(sum / count);
}

double Calibration::shortcut_cost() const {
  Largest worst;
  for (const Eigen::Index row : fit.rows) {
    worst.add(std::abs(whole[row] - fit.after[row]) / std::sqrt(fit.data.covariance(row, row)));
  }
  return worst.value();
}

Outcome Calibration::outcome() const {
  Outcome outcome{
      .name = "calibration",
      .suite = "calibration",
      .claim = "The recordings constrain parameters of the scene, and the fit is sound."};
  const auto at_bound = std::ranges::count_if(fit.parameters, &FittedParameter::at_bound);
  outcome.judge_true("search converged", fit.converged, "an unfinished search has no minimum");
  outcome.judge_at_least("constrained parameters", static_cast<double>(fit.told.size()), 1.0,
                         "without any nothing was fitted");
  outcome.judge_at_most("parameters at a bound", static_cast<double>(at_bound), 0.0,
                        "nothing is known beyond a bound");
  outcome.judge_at_most("misfit after the fit", fit.misfit_after, fit.misfit_before,
                        "the misfit before it");
  outcome.judge_at_most("largest effect of the shortcuts", shortcut_cost(),
                        std::nextafter(1.0, 0.0), "the uncertainty of the observable");
  palpate::conclude(outcome);
  return outcome;
}

namespace {

/// Returns the coarsest of three forms in which the scene can be simulated.
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
                      std::span<const ObservedRecording> recordings,
                      const CalibrationOptions& options) {
  const std::vector<ObservedRecording> subjects = by_subject(recordings);
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
