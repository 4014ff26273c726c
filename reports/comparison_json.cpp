// SPDX-License-Identifier: MIT

#include "fixtures/io/recording_file.hpp"
#include "reports/comparison_report.hpp"
#include "reports/results/results_json.hpp"

namespace palpate {

using namespace comparison;

namespace {

using Json = nlohmann::ordered_json;

constexpr int comparison_schema = 1;

Json optional_number(const std::optional<double>& value) {
  return value ? json_number(*value) : Json(nullptr);
}

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
    json[name] = optional_number(value);
  }
  void count(const char* name, std::size_t value) { json[name] = value; }
};

Json to_json(const Tolerance& tolerance) {
  return {{"absolute", tolerance.absolute},
          {"relative", tolerance.relative},
          {"factor", tolerance.factor},
          {"origin", tolerance.origin}};
}

Json to_json(const FeatureComparison& one) {
  return {{"name", name_of(one.feature)},
          {"unit", one.quantity.unit},
          {"recorded", optional_number(one.recorded.value)},
          {"simulated", optional_number(one.simulated.value)},
          {"error", json_number(one.error)},
          {"lower", json_number(one.quantity.lower)},
          {"upper", json_number(one.quantity.upper)},
          {"tolerance", to_json(one.tolerance)},
          {"u_num", one.uncertainty.numerical},
          {"u_input", one.uncertainty.input},
          {"u_data", one.uncertainty.data},
          {"u_val", one.uncertainty.total()},
          {"expanded_uncertainty", one.quantity.uncertainty},
          {"below_uncertainty", one.below_uncertainty},
          {"verdict", verdict_word(one.status)},
          {"reason", one.reason}};
}

Json list_of(const std::vector<FeatureComparison>& features) {
  Json list = Json::array();
  for (const FeatureComparison& one : features) { list.push_back(to_json(one)); }
  return list;
}

Json to_json(const std::optional<IsoRating>& rating) {
  if (!rating) { return nullptr; }
  return {{"corridor", json_number(rating->corridor)},
          {"phase", json_number(rating->phase)},
          {"magnitude", json_number(rating->magnitude)},
          {"slope", json_number(rating->slope)},
          {"overall", json_number(rating->overall)},
          {"grade", grade_of(rating->overall)},
          {"shift_samples", rating->shift},
          {"correlation", json_number(rating->correlation)},
          {"note", rating->note}};
}

Json to_json(const TraceErrors& errors) {
  return {{"samples", errors.samples},
          {"rmse", json_number(errors.rmse)},
          {"nrmse", json_number(errors.nrmse)},
          {"mean", json_number(errors.mean)},
          {"sprague_geers_magnitude", json_number(errors.magnitude)},
          {"sprague_geers_phase", json_number(errors.phase)},
          {"sprague_geers_combined", json_number(errors.combined)}};
}

Json to_json(const Alignment& alignment) {
  return {{"used", name_of(alignment.used)},
          {"how", alignment.how},
          {"lag_s", json_number(alignment.lag)},
          {"uncertainty_s", json_number(alignment.uncertainty)},
          {"times_are_judged", alignment.judges_times()}};
}

/// Writes the results that exist only for a compared recording.
void add_measures(Json& json, const Comparison& one) {
  json["alignment"] = to_json(one.alignment);
  json["cutoff_hz"] = json_number(one.cutoff);
  json["overlap_s"] = json_number(one.overlap);
  json["features"] = list_of(one.features);
  json["distances"] = to_json(one.errors);
  json["rating"] = to_json(one.rating);
  json["unfiltered_rating"] = to_json(one.unfiltered_rating);
  json["rated_share"] = json_number(one.rated);
}

Json to_json(const ComparedRecording& input, const Comparison& one) {
  const Recording& recording = input.input.recording;
  Json json{{"file", input.file.filename().string()},
            {"format", name_of(input.input.format)},
            {"fnv1a", input.hash}};
  FieldWriter writer{json};
  io::for_each_attribute(recording, writer);
  json["samples"] = recording.time.size();
  Json defects = Json::object();
  FieldWriter defect_writer{defects};
  io::for_each_defect(recording.defects, defect_writer);
  json["defects"] = defects;
  json["warnings"] = input.input.warnings;
  json["verdict"] = verdict_word(one.outcome.status);
  json["reasons"] = one.outcome.reasons;
  if (one.outcome.status != Status::error) { add_measures(json, one); }
  return json;
}

Json to_json(const Interval& interval) { return Json::array({interval.lower, interval.upper}); }

Json to_json(const FeatureSummary& one) {
  return {{"name", name_of(one.feature)},
          {"unit", one.unit},
          {"count", one.count},
          {"mean", json_number(one.mean)},
          {"standard_deviation", json_number(one.deviation)},
          {"mean_interval_95", one.interval ? to_json(*one.interval) : Json(nullptr)},
          {"simulated", optional_number(one.simulated)}};
}

Json corridor_of(const GroupSummary& group, const CorridorRule& rule) {
  if (!group.corridor) { return {{"refused", group.corridor_refusal}}; }
  const CorridorCoverage& coverage = group.coverage;
  return {{"recordings", group.corridor->recordings},
          {"subjects", group.corridor->subjects},
          {"half_width_sd", group.corridor->factor},
          {"inside", json_number(coverage.inside)},
          {"least_inside", rule.least_inside},
          {"largest_excursion", json_number(coverage.largest_excursion)},
          {"largest_excursion_at_s", json_number(coverage.excursion_time)},
          {"holds", coverage.holds}};
}

Json to_json(const GroupSummary& group, const CorridorRule& rule) {
  Json features = Json::array();
  for (const FeatureSummary& one : group.features) { features.push_back(to_json(one)); }
  return {{"group", group.group},
          {"recordings", group.recordings},
          {"subjects", group.subjects},
          {"measured", group.measured},
          {"reconstructed", group.recordings - group.measured},
          {"agree", group.tally.passed},
          {"not_distinguishable", group.tally.inconclusive},
          {"differ", group.tally.failed},
          {"not_comparable", group.tally.errors},
          {"subjects_agree", group.subjects_agree},
          {"agree_share", json_number(group.agree_share)},
          {"agree_interval_95", group.subjects > 0 ? to_json(group.agree_interval) : Json(nullptr)},
          {"features", features},
          {"means_judged", list_of(group.means)},
          {"corridor", corridor_of(group, rule)},
          {"verdict", verdict_word(group.outcome.status)},
          {"reasons", group.outcome.reasons}};
}

Json to_json(const ComparedSimulation& simulation) {
  const std::vector<double>& time = simulation.trace.time;
  return {{"origin", simulation.origin == ComparedSimulation::Origin::scene ? "scene" : "trace"},
          {"file", simulation.file.filename().string()},
          {"fnv1a", simulation.hash},
          {"title", simulation.title},
          {"duration_s", time.empty() ? Json(nullptr) : json_number(time.back() - time.front())},
          {"run_longer_s", simulation.run_longer},
          {"failure", simulation.failure}};
}

Json options_of(const GroupOptions& options) {
  const ComparisonOptions& o = options.comparison;
  const LossRule& loss = o.features.loss;
  return {{"quantity", name_of(o.quantity)},
          {"alignment", name_of(o.alignment)},
          {"cutoff_hz", o.cutoff},
          {"grid_rate_hz", o.grid_rate},
          {"least_overlap_s", o.least_overlap},
          {"loss_of_resistance",
           {{"least_drop", loss.least_drop},
            {"hold_s", loss.hold},
            {"settle_s", loss.settle},
            {"longest_fall_s", loss.longest_fall},
            {"unsteady", loss.unsteady},
            {"least_peak", loss.least_peak}}},
          {"u_zero", o.quantity == QuantityKind::pressure ? o.uncertainties.transducer.zero
                                                          : o.uncertainties.zero_force},
          {"u_gain", o.uncertainties.transducer.gain},
          {"u_num", o.uncertainties.numerical},
          {"u_input", o.uncertainties.input},
          {"coverage_factor", o.uncertainties.coverage_factor},
          {"bootstrap_draws", options.bootstrap.draws},
          {"bootstrap_seed", options.bootstrap.seed}};
}

Json to_json(const CredibilityFactor& factor) {
  return {{"activity", factor.activity},    {"factor", factor.factor},     {"goal", factor.goal},
          {"shown", name_of(factor.shown)}, {"evidence", factor.evidence}, {"links", factor.links}};
}

}  // namespace

std::string to_json(const ComparisonReport& report) {
  Json json{{"schema", comparison_schema},
            {"verdict", verdict_word(report.found.outcome.status)},
            {"holds", holds(report)},
            {"sentence", verdict_sentence(report)},
            {"reasons", report.found.outcome.reasons},
            {"quantity", name_of(report.options.comparison.quantity)},
            {"unit", unit_of(report.options.comparison.quantity)},
            {"simulation", to_json(report.simulation)},
            {"options", options_of(report.options)}};
  json["recordings"] = Json::array();
  for (std::size_t n = 0; n < report.recordings.size(); ++n) {
    json["recordings"].push_back(to_json(report.recordings[n], report.found.recordings.at(n)));
  }
  json["groups"] = Json::array();
  for (const GroupSummary& group : report.found.groups) {
    json["groups"].push_back(to_json(group, report.options.corridor));
  }
  json["credibility"] = Json::array();
  for (const CredibilityFactor& factor : report.credibility) {
    json["credibility"].push_back(to_json(factor));
  }
  json["command"] = report.command;
  json["provenance"] = report.provenance;
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace palpate
