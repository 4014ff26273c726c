// SPDX-License-Identifier: MIT

#include "fixtures/io/recording_file.hpp"
#include "reports/comparison_report.hpp"
#include "reports/results/results_json.hpp"

namespace palpate {

using namespace comparison;

namespace {

using Json = nlohmann::ordered_json;

/// Writes the attributes or the defects of a recording into an object.
struct FieldWriter {
  Json& json;
  template <class Value, class Words>
  void word(const char* name, Value value, const Words& /*words*/) {
    json[name] = io::word_of(value);
  }
  void text(const char* name, const std::string& value) { json[name] = value; }
  void number(const char* name, double value) { json[name] = json_number(value); }
  void number(const char* name, const std::optional<double>& value) {
    json[name] = json_value(value);
  }
  void count(const char* name, std::size_t value) { json[name] = value; }
};

Json feature_json(const FeatureComparison& one) {
  const Tolerance& tolerance = one.tolerance;
  return object("name", name_of(one.feature), "unit", one.quantity.unit, "recorded",
                one.recorded.value, "simulated", one.simulated.value, "error", one.error, "lower",
                one.quantity.lower, "upper", one.quantity.upper, "tolerance",
                object("absolute", tolerance.absolute, "relative", tolerance.relative, "factor",
                       tolerance.factor, "origin", tolerance.origin),
                "u_num", one.uncertainty.numerical, "u_input", one.uncertainty.input, "u_data",
                one.uncertainty.data, "u_val", one.uncertainty.total(), "expanded_uncertainty",
                one.quantity.uncertainty, "below_uncertainty", one.below_uncertainty, "verdict",
                verdict_word(one.status), "reason", one.reason);
}

Json rating_json(const std::optional<IsoRating>& rating) {
  if (!rating) { return nullptr; }
  return object("corridor", rating->corridor, "phase", rating->phase, "magnitude",
                rating->magnitude, "slope", rating->slope, "overall", rating->overall, "grade",
                grade_of(rating->overall), "shift_samples", rating->shift, "correlation",
                rating->correlation, "note", rating->note);
}

/// Adds the results that exist only for a compared recording.
void add_measures(Json& json, const Comparison& one) {
  const Alignment& alignment = one.alignment;
  const TraceErrors& errors = one.errors;
  add_keys(
      json, "alignment",
      object("used", name_of(alignment.used), "how", alignment.how, "lag_s", alignment.lag,
             "uncertainty_s", alignment.uncertainty, "times_are_judged", alignment.judges_times()),
      "cutoff_hz", one.cutoff, "overlap_s", one.overlap, "features",
      list_of(one.features, feature_json), "distances",
      object("samples", errors.samples, "rmse", errors.rmse, "nrmse", errors.nrmse, "mean",
             errors.mean, "sprague_geers_magnitude", errors.magnitude, "sprague_geers_phase",
             errors.phase, "sprague_geers_combined", errors.combined),
      "rating", rating_json(one.rating), "unfiltered_rating", rating_json(one.unfiltered_rating),
      "rated_share", one.rated);
}

Json recording_json(const RecordingFile& input, const Comparison& one) {
  const Recording& recording = input.input.recording;
  Json json = object("file", input.file.filename().string(), "format", name_of(input.input.format),
                     "fnv1a", input.hash);
  FieldWriter writer{json};
  io::for_each_attribute(recording, writer);
  Json defects = Json::object();
  FieldWriter defect_writer{defects};
  io::for_each_defect(recording.defects, defect_writer);
  add_keys(json, "samples", recording.time.size(), "defects", defects, "warnings",
           input.input.warnings, "verdict", verdict_word(one.outcome.status), "reasons",
           one.outcome.reasons);
  if (one.outcome.status != Status::error) { add_measures(json, one); }
  return json;
}

Json interval_json(const Interval& interval) { return {interval.lower, interval.upper}; }

Json summary_json(const FeatureSummary& one) {
  return object("name", name_of(one.feature), "unit", one.unit, "count", one.count, "mean",
                one.mean, "standard_deviation", one.deviation, "mean_interval_95",
                one.interval ? interval_json(*one.interval) : Json(nullptr), "simulated",
                one.simulated);
}

Json corridor_json(const GroupSummary& group, const CorridorRule& rule) {
  if (!group.corridor) { return object("refused", group.corridor_refusal); }
  const CorridorCoverage& coverage = group.coverage;
  return object("recordings", group.corridor->recordings, "subjects", group.corridor->subjects,
                "half_width_sd", group.corridor->factor, "inside", coverage.inside, "least_inside",
                rule.least_inside, "largest_excursion", coverage.largest_excursion,
                "largest_excursion_at_s", coverage.excursion_time, "holds", coverage.holds);
}

Json group_json(const GroupSummary& group, const CorridorRule& rule) {
  return object("group", group.group, "recordings", group.recordings, "subjects", group.subjects,
                "measured", group.measured, "reconstructed", group.recordings - group.measured,
                "agree", group.tally.passed, "not_distinguishable", group.tally.inconclusive,
                "differ", group.tally.failed, "not_comparable", group.tally.errors,
                "subjects_agree", group.subjects_agree, "agree_share", group.agree_share,
                "agree_interval_95",
                group.subjects > 0 ? interval_json(group.agree_interval) : Json(nullptr),
                "features", list_of(group.features, summary_json), "means_judged",
                list_of(group.means, feature_json), "corridor", corridor_json(group, rule),
                "verdict", verdict_word(group.outcome.status), "reasons", group.outcome.reasons);
}

Json simulation_json(const ComparedSimulation& simulation) {
  const std::vector<double>& time = simulation.trace.time;
  return object(
      "origin", simulation.origin == ComparedSimulation::Origin::scene ? "scene" : "trace", "file",
      simulation.file.filename().string(), "fnv1a", simulation.hash, "title", simulation.title,
      "duration_s", time.empty() ? Json(nullptr) : json_number(time.back() - time.front()),
      "run_longer_s", simulation.run_longer, "failure", simulation.failure);
}

Json options_json(const GroupOptions& options) {
  const ComparisonOptions& o = options.comparison;
  const Uncertainties& u = o.uncertainties;
  const LossRule& loss = o.features.loss;
  return object("quantity", name_of(o.quantity), "alignment", name_of(o.alignment), "cutoff_hz",
                o.cutoff, "grid_rate_hz", o.grid_rate, "least_overlap_s", o.least_overlap,
                "loss_of_resistance",
                object("least_drop", loss.least_drop, "hold_s", loss.hold, "settle_s", loss.settle,
                       "longest_fall_s", loss.longest_fall, "unsteady", loss.unsteady, "least_peak",
                       loss.least_peak),
                "u_zero", o.quantity == QuantityKind::pressure ? u.transducer.zero : u.zero_force,
                "u_gain", u.transducer.gain, "u_num", u.numerical, "u_input", u.input,
                "coverage_factor", u.coverage_factor, "bootstrap_draws", options.bootstrap.draws,
                "bootstrap_seed", options.bootstrap.seed);
}

Json credibility_json(const CredibilityFactor& factor) {
  return object("activity", factor.activity, "factor", factor.factor, "goal", factor.goal, "shown",
                name_of(factor.shown), "evidence", factor.evidence, "links", factor.links);
}

}  // namespace

std::string to_json(const ComparisonReport& report) {
  Json recordings = Json::array();
  for (std::size_t n = 0; n < report.recordings.size(); ++n) {
    recordings.push_back(recording_json(report.recordings[n], report.found.recordings.at(n)));
  }
  const QuantityKind quantity = report.options.comparison.quantity;
  const auto of_group = [&](const GroupSummary& group) {
    return group_json(group, report.options.corridor);
  };
  return json_text(object("schema", 1, "verdict", verdict_word(report.found.outcome.status),
                          "holds", holds(report), "sentence", verdict_sentence(report), "reasons",
                          report.found.outcome.reasons, "quantity", name_of(quantity), "unit",
                          unit_of(quantity), "simulation", simulation_json(report.simulation),
                          "options", options_json(report.options), "recordings", recordings,
                          "groups", list_of(report.found.groups, of_group), "credibility",
                          list_of(report.credibility, credibility_json), "command", report.command,
                          "provenance", report.provenance));
}

}  // namespace palpate
