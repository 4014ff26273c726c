// SPDX-License-Identifier: MIT

#include "validation/calibration/insertion_fit.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "validation/random.hpp"
#include "validation/roll_out.hpp"

namespace palpate::calibration {

using comparison::Feature;

namespace {

constexpr auto feature_total = static_cast<Eigen::Index>(fitted_features.size());

/// Low-pass of forces [Hz], as the default of a comparison.
constexpr double cutoff = 20.0;

comparison::Features features_in(const comparison::RawTrace& trace) {
  const comparison::FeatureRule rule{.set = comparison::FeatureSet::insertion};
  const double usual = 1.0 / sampling_of(trace.time).period;
  return comparison::prepare(trace, std::min(cutoff, 0.25 * usual), rule).features;
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

}  // namespace

Observation observed_features(const Recording& recording) {
  return values_of(
      features_in({.time = recording.time, .value = recording.force, .depth = recording.depth}));
}

Observation simulated_features(const Trace& trace) {
  const std::vector<double>& force = trace.values("tool.force_n");
  const std::vector<double>& depth = trace.values("tool.insertion_m");
  const comparison::Features found =
      features_in({.time = trace.time, .value = force, .depth = depth});
  Observation values = values_of(found);
  const auto& contact = found.phases.contact_depth.value;
  if (!std::isfinite(values[index_of(Feature::puncture_force)]) && contact) {
    const auto largest = static_cast<std::size_t>(std::ranges::max_element(force) - force.begin());
    values[index_of(Feature::puncture_force)] = force[largest];
    values[index_of(Feature::puncture_depth)] = depth[largest] - *contact;
    values[index_of(Feature::force_left)] = force[largest];
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
    return "drive: an insertion needs a needle with kind = \"trajectory\", a depth and a "
           "withdraw_speed";
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

ObservedInsertion simulate(const Scene& scene, const std::atomic<bool>* stop) {
  ModelSubject subject{Simulation(scene)};
  const Trace run = roll_out(subject, scene, {}, {.stop = stop});
  if (run.interrupted) { throw Interrupted(); }
  if (run.diverged) {
    return {.refusal = "diverges at t = " + std::to_string(run.diverged_at) + " s"};
  }
  return {.value = simulated_features(run)};
}

/// Returns the mean and standard deviation of each feature over recordings.
std::vector<FeatureCheck> measured(const std::vector<Recording>& recordings) {
  std::vector<Observation> seen;
  for (const Recording& recording : recordings) { seen.push_back(observed_features(recording)); }
  std::vector<FeatureCheck> features;
  for (Eigen::Index n = 0; n < feature_total; ++n) {
    FeatureCheck& one = features.emplace_back(
        FeatureCheck{.feature = fitted_features[static_cast<std::size_t>(n)]});
    double sum = 0.0;
    for (const Observation& each : seen) {
      if (!std::isfinite(each[n])) { continue; }
      sum += each[n];
      ++one.count;
    }
    if (one.count == 0) { continue; }
    const auto count = static_cast<double>(one.count);
    one.mean = sum / count;
    if (one.count < 2) { continue; }
    double squares = 0.0;
    for (const Observation& each : seen) {
      if (std::isfinite(each[n])) { squares += (each[n] - one.mean) * (each[n] - one.mean); }
    }
    one.deviation = std::sqrt(squares / (count - 1.0));
  }
  return features;
}

std::size_t subjects_in(const std::vector<Recording>& recordings) {
  std::set<std::string> codes;
  std::size_t nameless = 0;
  for (const Recording& each : recordings) {
    if (each.subject.empty()) { ++nameless; }
    codes.insert(each.subject);
  }
  return nameless > 0 ? codes.size() - 1 + nameless : codes.size();
}

/// Returns the rows of the fitted conditions, one after the other.
Pooled pooled(const std::vector<Condition>& conditions) {
  constexpr double least = 0.01;  // of the mean: recordings of one needle agree by chance
  Pooled all;
  std::vector<double> mean;
  std::vector<double> variance;
  for (const Condition& condition : conditions) {
    if (!condition.fitted) { continue; }
    const std::size_t subjects = subjects_in(condition.recordings);
    all.subjects = std::max(all.subjects, subjects);
    for (const FeatureCheck& one : measured(condition.recordings)) {
      const bool usable = std::isfinite(one.deviation);
      const double spread = std::max(one.deviation / std::sqrt(static_cast<double>(subjects)),
                                     least * std::abs(one.mean));
      mean.push_back(usable ? one.mean : comparison::not_measured);
      variance.push_back(usable ? spread * spread : 0.0);
      all.count.push_back(one.count);
    }
  }
  all.mean = Eigen::VectorXd::Map(mean.data(), std::ssize(mean));
  all.covariance = Eigen::VectorXd::Map(variance.data(), std::ssize(variance)).asDiagonal();
  return all;
}

Scene at_values(const Scene& scene, const std::vector<Parameter>& parameters,
                const std::vector<double>& values) {
  std::vector<Parameter> own;
  std::vector<double> of_own;
  const std::vector<Parameter> has = parameters_of(scene);
  for (std::size_t n = 0; n < parameters.size(); ++n) {
    if (std::ranges::find(has, parameters[n].key, &Parameter::key) == has.end()) { continue; }
    own.push_back(parameters[n]);
    of_own.push_back(values[n]);
  }
  return with_values(scene, own, of_own);
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

/// Returns the searches' starting values: the priors, then places around them, the same each time.
std::vector<std::vector<Parameter>> starts_of(const std::vector<Parameter>& parameters, int count) {
  constexpr double away = 0.5;  // prior spreads
  std::vector<std::vector<Parameter>> starts{parameters};
  Random random(1);
  for (int n = 1; n < count; ++n) {
    starts.push_back(parameters);
    for (Parameter& each : starts.back()) {
      each.prior = each.value(random(0.0, 1.0) < 0.5 ? -away : away);
    }
  }
  return starts;
}

/// Simulates conditions at the fit, and at the priors.
std::vector<ConditionCheck> checks(const std::vector<Condition>& conditions,
                                   const std::vector<Parameter>& parameters,
                                   const std::vector<double>& values,
                                   const InsertionFitOptions& options) {
  std::vector<double> priors;
  for (const Parameter& each : parameters) { priors.push_back(each.prior); }
  std::vector<ConditionCheck> all;
  for (const Condition& condition : conditions) {
    ConditionCheck& one =
        all.emplace_back(ConditionCheck{.name = condition.name,
                                        .fitted = condition.fitted,
                                        .recordings = condition.recordings.size(),
                                        .scene = at_values(condition.scene, parameters, values),
                                        .features = measured(condition.recordings)});
    Forward before(bare(at_values(condition.scene, parameters, priors)), {}, 1, options.stop,
                   options.simulate);
    Forward after(bare(one.scene), {}, 1, options.stop, options.simulate);
    const Observation first = before.at(Forward::Values{});
    const Observation last = after.at(Forward::Values{});
    for (Eigen::Index n = 0; n < feature_total; ++n) {
      one.features[static_cast<std::size_t>(n)].before = first[n];
      one.features[static_cast<std::size_t>(n)].after = last[n];
    }
  }
  return all;
}

/// Returns the conditions with the recordings of one subject, or with all but those.
std::vector<Condition> of_subject(std::vector<Condition> conditions, const std::string& subject,
                                  bool its_own) {
  for (Condition& condition : conditions) {
    std::erase_if(condition.recordings, [&](const Recording& recording) {
      return (recording.subject == subject) != its_own;
    });
  }
  std::erase_if(conditions, [](const Condition& one) { return one.recordings.empty(); });
  return conditions;
}

std::set<std::string> subjects_of(const std::vector<Condition>& conditions) {
  std::set<std::string> subjects;
  for (const Condition& condition : conditions) {
    if (!condition.fitted) { continue; }
    for (const Recording& recording : condition.recordings) { subjects.insert(recording.subject); }
  }
  return subjects;
}

std::vector<LeftOutSubject> leave_out(const std::vector<Condition>& conditions, const Fit& fit,
                                      const InsertionFitOptions& options) {
  std::vector<LeftOutSubject> all;
  const std::set<std::string> subjects = subjects_of(conditions);
  if (subjects.size() < 2) { return all; }
  std::vector<Parameter> from_fit;
  for (const FittedParameter& each : fit.parameters) { from_fit.push_back(each.parameter); }
  for (const std::string& subject : subjects) {
    if (options.progress) { options.progress("without " + subject); }
    std::vector<Condition> others;
    for (const Condition& each : of_subject(conditions, subject, false)) {
      if (each.fitted) { others.push_back(each); }
    }
    Forward forward(fitted_scenes(others), from_fit, options.jobs, options.stop, options.simulate);
    const Pooled data = pooled(others);
    const Search::Found found = Search(forward, data, fit.told).from(fit.values());
    all.push_back({.subject = subject,
                   .converged = found.converged,
                   .conditions = checks(of_subject(conditions, subject, true), from_fit,
                                        found.values, options)});
  }
  return all;
}

}  // namespace

Outcome InsertionFit::outcome() const {
  Outcome outcome{.name = "calibration",
                  .suite = "calibration",
                  .claim = "Tissue that is fitted to some insertions predicts others."};
  outcome.judge_true("search converged", fit.converged, "an unfinished search has no minimum");
  const bool predicts = std::ranges::any_of(conditions, [](const auto& c) { return !c.fitted; });
  for (const ConditionCheck& condition : conditions) {
    if (condition.fitted == predicts) { continue; }
    for (const FeatureCheck& one : condition.features) {
      if (!std::isfinite(one.deviation)) { continue; }
      outcome.judge_at_most(condition.name + ": " + std::string(comparison::name_of(one.feature)),
                            std::isfinite(one.after) ? std::abs(one.distance())
                                                     : std::numeric_limits<double>::infinity(),
                            2.0, "standard deviations of the recordings");
    }
  }
  palpate::conclude(outcome);
  return outcome;
}

InsertionFit fit_insertions(const std::vector<Condition>& conditions,
                            const std::vector<Parameter>& parameters,
                            const InsertionFitOptions& given) {
  InsertionFitOptions options = given;
  if (!options.simulate) {
    options.simulate = [stop = options.stop](const Scene& scene) { return simulate(scene, stop); };
  }
  const Pooled data = pooled(conditions);
  InsertionFit result;
  double least = std::numeric_limits<double>::infinity();
  for (const std::vector<Parameter>& start : starts_of(parameters, options.starts)) {
    if (options.progress) { options.progress("fitting"); }
    Forward forward(fitted_scenes(conditions), start, options.jobs, options.stop, options.simulate);
    Fit found = fit(forward, data);
    result.simulations += forward.simulations();
    if (found.misfit_after < least) {
      least = found.misfit_after;
      result.fit = std::move(found);
    }
  }
  result.starts = static_cast<std::size_t>(options.starts);
  if (options.progress) { options.progress("predicting"); }
  result.conditions = checks(conditions, parameters, result.fit.values(), options);
  if (options.leave_out) { result.left_out = leave_out(conditions, result.fit, options); }
  return result;
}

}  // namespace palpate::calibration
