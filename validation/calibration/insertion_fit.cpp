// SPDX-License-Identifier: MIT

#include "validation/calibration/insertion_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <span>
#include <stdexcept>

#include "validation/random.hpp"
#include "validation/roll_out.hpp"

namespace palpate::calibration {

using comparison::Feature;
using comparison::FeatureSummary;

namespace {

constexpr auto feature_total = static_cast<Eigen::Index>(fitted_features.size());
/// Depths of features are multiples of the tip's path within a step, some thousandth of a dent, so
/// that the sum of squares is a staircase: a finer search finds nothing more.
constexpr reference::LeastSquaresRule search_rule{
    .most_iterations = 20, .step_tolerance = 1e-3, .gradient_tolerance = 1e-4};
constexpr double infinite = std::numeric_limits<double>::infinity();

/// Options of the comparison whose features are fitted.
comparison::ComparisonOptions comparison_options() {
  comparison::ComparisonOptions options{.quantity = comparison::QuantityKind::insertion};
  options.column = comparison::column_of(options);
  return options;
}

comparison::Features features_in(const comparison::RawTrace& trace) {
  const double usual = 1.0 / sampling_of(trace.time).period;
  const double low_pass = std::min(comparison_options().cutoff, 0.25 * usual);
  return comparison::prepare(trace, low_pass, {.set = comparison::FeatureSet::insertion}).features;
}

Observation values_of(const comparison::Features& found) {
  Observation values = Observation::Constant(feature_total, comparison::not_measured);
  for (Eigen::Index n = 0; n < feature_total; ++n) {
    values[n] = found[fitted_features[static_cast<std::size_t>(n)]].value.value_or(
        comparison::not_measured);
  }
  return values;
}

Eigen::Index index_of(Feature feature) {
  return std::ranges::find(fitted_features, feature) - fitted_features.begin();
}

const std::vector<double>& depth_of(const Trace& trace) {
  return trace.values(comparison::depth_column_of(comparison_options(), trace));
}

}  // namespace

Observation observed_features(const Recording& recording) {
  return values_of(
      features_in({.time = recording.time, .value = recording.force, .depth = recording.depth}));
}

Observation simulated_features(const Trace& trace) {
  const std::vector<double>& force = trace.values(comparison_options().column);
  const std::vector<double>& depth = depth_of(trace);
  const comparison::Features found =
      features_in({.time = trace.time, .value = force, .depth = depth});
  Observation values = values_of(found);
  const auto& contact = found.phases.contact_depth.value;
  if (!std::isfinite(values[index_of(Feature::puncture_force)]) && contact) {
    const auto deepest = std::ranges::max_element(depth) - depth.begin();
    const auto largest = std::max_element(force.begin(), force.begin() + deepest) - force.begin();
    values[index_of(Feature::puncture_force)] = values[index_of(Feature::largest_force)];
    values[index_of(Feature::puncture_depth)] = depth[static_cast<std::size_t>(largest)] - *contact;
    values[index_of(Feature::force_left)] = values[index_of(Feature::largest_force)];
  }
  return values;
}

std::vector<Parameter> parameters_of(const std::vector<Condition>& conditions) {
  std::vector<Parameter> all;
  for (const Condition& condition : conditions) {
    if (!condition.fitted) { continue; }
    for (const Parameter& each : parameters_of(condition.scene)) {
      const bool known = std::ranges::find(all, each.key, &Parameter::key) != all.end();
      if (!known && each.key.starts_with("material.")) { all.push_back(each); }
    }
  }
  return all;
}

std::string why_not_calibrated(const Condition& condition) {
  const Scene& scene = condition.scene;
  if (scene.tissue.source != Source::layers) {
    return "tissue.source: layers are what is calibrated; \"layers\"";
  }
  const Drive drive = scene.drive.value_or(Drive{});
  if (!scene.needle || drive.kind != Drive::Kind::trajectory || !drive.depth ||
      !(drive.withdraw_speed > 0.0)) {
    return "drive: a measured insertion is simulated by a needle with kind = \"trajectory\", a "
           "depth and a withdraw_speed";
  }
  if (condition.recordings.empty()) { return "no recording of this condition was given"; }
  for (const Recording& recording : condition.recordings) {
    if (recording.force.empty() || recording.depth.empty()) {
      return recording.name + ": force and depth are needed; it lacks " +
             (recording.force.empty() ? "the force" : "the depth");
    }
  }
  return {};
}

namespace {

/// Returns the features; all NaN if the run diverged.
ObservedInsertion observed(const Trace& run) {
  return {.value = run.diverged ? Observation::Constant(feature_total, comparison::not_measured)
                                : simulated_features(run)};
}

std::set<std::string> needles_of(std::span<const Condition> conditions) {
  std::set<std::string> needles;
  for (const Condition& condition : conditions) {
    if (!condition.fitted) { continue; }
    for (const Recording& recording : condition.recordings) { needles.insert(recording.subject); }
  }
  return needles;
}

/// Returns the mean features of the fitted conditions, one condition after the other.
Pooled pooled(const std::vector<Condition>& conditions) {
  constexpr double least = 0.01;  // of the mean: a few recordings may agree by chance
  Pooled all{.subjects = needles_of(conditions).size()};
  std::vector<double> mean;
  std::vector<double> variance;
  for (const Condition& condition : conditions) {
    if (!condition.fitted) { continue; }
    const auto needles = static_cast<double>(needles_of({&condition, 1}).size());
    std::vector<Observation> seen;
    for (const Recording& each : condition.recordings) { seen.push_back(observed_features(each)); }
    for (Eigen::Index n = 0; n < feature_total; ++n) {
      std::vector<double> values;
      for (const Observation& each : seen) {
        if (std::isfinite(each[n])) { values.push_back(each[n]); }
      }
      const bool usable = values.size() > 1;
      const double middle = usable ? comparison::mean_of(values) : comparison::not_measured;
      const double spread = usable ? std::max(comparison::deviation_of(values) / std::sqrt(needles),
                                              least * std::abs(middle))
                                   : 0.0;
      mean.push_back(middle);
      variance.push_back(spread * spread);
      all.count.push_back(values.size());
    }
  }
  all.mean = Eigen::VectorXd::Map(mean.data(), std::ssize(mean));
  all.covariance = Eigen::VectorXd::Map(variance.data(), std::ssize(variance)).asDiagonal();
  return all;
}

/// Scene without what only a page shows.
Scene bare(Scene scene) {
  scene.output.frames = 0;
  scene.records.clear();
  return scene;
}

std::vector<Scene> fitted_scenes(const std::vector<Condition>& conditions) {
  std::vector<Scene> scenes;
  for (const Condition& each : conditions) {
    if (each.fitted) { scenes.push_back(bare(each.scene)); }
  }
  return scenes;
}

/// Returns the starting values of the searches: the priors, then places around them, the same each
/// time.
std::vector<Forward::Values> starts_of(const std::vector<Parameter>& parameters, int count) {
  constexpr double away = 0.5;  // prior spreads
  std::vector<Forward::Values> starts(1);
  for (const Parameter& each : parameters) { starts.front().push_back(each.prior); }
  Random random(1);
  for (int n = 1; n < count; ++n) {
    Forward::Values& start = starts.emplace_back();
    for (const Parameter& each : parameters) {
      const double place = each.value(random(0.0, 1.0) < 0.5 ? -away : away);
      start.push_back(std::clamp(place, each.lower, each.upper));
    }
  }
  return starts;
}

/// Fits the same rows from each start and keeps the best.
void search_from(const std::vector<Forward::Values>& starts, Forward& forward, const Pooled& data,
                 InsertionFit& result) {
  double least = infinite;
  std::string reason;
  for (const Forward::Values& start : starts) {
    try {
      Fit found = fit(forward, data, start, search_rule);
      result.misfits.push_back(found.misfit_after);
      if (found.misfit_after >= least) { continue; }
      least = found.misfit_after;
      result.fit = std::move(found);
    } catch (const Interrupted&) { throw; } catch (const std::runtime_error& error) {
      result.misfits.push_back(infinite);
      reason = error.what();
    }
  }
  if (!std::isfinite(least)) { throw std::runtime_error(reason); }
}

using Simulate = std::function<Trace(const Scene&)>;

std::vector<ConditionCheck> checks(const std::vector<Condition>& conditions,
                                   const std::vector<Parameter>& parameters,
                                   const std::vector<double>& values, const Simulate& simulate) {
  std::vector<ConditionCheck> all;
  for (const Condition& condition : conditions) {
    ConditionCheck& one =
        all.emplace_back(ConditionCheck{.name = condition.name,
                                        .fitted = condition.fitted,
                                        .scene = with_values(condition.scene, parameters, values)});
    one.simulated = simulate(one.scene);
    std::vector<Recording> recordings = condition.recordings;
    for (Recording& each : recordings) { each.group = condition.name; }
    one.comparison =
        comparison::compare_all(recordings, one.simulated, {.comparison = comparison_options()});
  }
  return all;
}

/// Returns the conditions with the recordings of one needle, or with all but those.
std::vector<Condition> of_needle(std::vector<Condition> conditions, const std::string& needle,
                                 bool its_own) {
  for (Condition& condition : conditions) {
    std::erase_if(condition.recordings, [&](const Recording& recording) {
      return (recording.subject == needle) != its_own;
    });
  }
  std::erase_if(conditions, [](const Condition& one) { return one.recordings.empty(); });
  return conditions;
}

}  // namespace

std::vector<FeatureError> judged_features(const ConditionCheck& condition) {
  std::vector<FeatureError> errors;
  for (const FeatureSummary& one : condition.group().features) {
    if (comparison::is_event(one.feature) || !std::isfinite(one.deviation)) { continue; }
    errors.push_back(
        {&one, one.simulated ? (*one.simulated - one.mean) / one.deviation : infinite});
  }
  return errors;
}

Outcome InsertionFit::outcome() const {
  Outcome outcome{.name = "calibration",
                  .suite = "calibration",
                  .claim = "Tissue that is fitted to some insertions predicts others."};
  const auto at_bound = std::ranges::count_if(fit.parameters, &FittedParameter::at_bound);
  outcome.judge_true("search converged", fit.converged, "an unfinished search has no minimum");
  outcome.judge_at_most("parameters at a bound", at_bound, 0.0, "nothing is known beyond a bound");
  outcome.judge_at_least("parameters that the recordings tell",
                         static_cast<double>(fit.told.size()), 1.0,
                         "without one nothing was fitted");
  const bool predicts = std::ranges::any_of(conditions, [](const auto& c) { return !c.fitted; });
  for (const ConditionCheck& condition : conditions) {
    const std::vector<FeatureError> errors = judged_features(condition);
    outcome.judge_at_least(condition.name + ": features of two recordings or more",
                           static_cast<double>(errors.size()), 1.0,
                           "without one the condition shows nothing");
    if (condition.fitted == predicts) { continue; }
    for (const FeatureError& one : errors) {
      outcome.judge_at_most(
          condition.name + ": " + std::string(comparison::name_of(one.feature->feature)),
          std::abs(one.deviations), FeatureError::most_deviations,
          "standard deviations of the recordings");
    }
  }
  palpate::conclude(outcome);
  return outcome;
}

InsertionFit fit_insertions(std::vector<Condition> conditions,
                            const std::vector<Parameter>& parameters,
                            const InsertionFitOptions& options) {
  const auto tell = [&](const std::string& stage) {
    if (options.progress) { options.progress(stage); }
  };
  const Simulate simulate =
      options.simulate ? options.simulate : [stop = options.stop](const Scene& scene) {
        ModelSubject subject{Simulation(scene)};
        return run_to_end(subject, scene, stop);
      };
  const Forward::Simulate observe_run = [&](const Scene& scene) {
    return observed(simulate(scene));
  };
  InsertionFit result;
  tell("fitting");
  Forward forward(fitted_scenes(conditions), parameters, options.jobs, options.stop, observe_run);
  search_from(starts_of(parameters, options.starts), forward, pooled(conditions), result);
  result.simulations = forward.simulations();
  tell("predicting");
  const Forward::Values values = result.fit.values();
  result.conditions = checks(conditions, parameters, values, simulate);
  const std::set<std::string> needles = needles_of(conditions);
  if (needles.size() < 2) { return result; }
  for (const std::string& needle : needles) {
    tell("fitting without needle " + needle);
    const std::vector<Condition> others = of_needle(conditions, needle, false);
    const Pooled data = pooled(others);
    Forward without(fitted_scenes(others), parameters, options.jobs, options.stop, observe_run);
    const Search::Found found = Search(without, data, result.fit.told).from(values, search_rule);
    result.left_out.push_back({.needle = needle,
                               .converged = found.converged,
                               .conditions = checks(of_needle(conditions, needle, true), parameters,
                                                    found.values, simulate)});
    result.simulations += without.simulations();
  }
  return result;
}

}  // namespace palpate::calibration
