// SPDX-License-Identifier: MIT
#include <nlohmann/json.hpp>

#include "reports/calibration_report.hpp"
#include "reports/json_number.hpp"

namespace palpate {
namespace {

using namespace calibration;
using Json = nlohmann::ordered_json;

Json parameter_json(const FittedParameter& each) {
  const Parameter& p = each.parameter;
  return {{"key", p.key},
          {"unit", p.unit},
          {"status", name_of(each.telling)},
          {"prior", p.prior},
          {"prior_log_sd", p.spread},
          {"prior_from", p.origin},
          {"lower_bound", p.lower},
          {"upper_bound", p.upper},
          {"value", each.value},
          {"interval_lower", each.interval.lower},
          {"interval_upper", each.interval.upper},
          {"interval_factor", each.interval_factor},
          {"sensitivity", finite_or_null(each.sensitivity)},
          {"deviation_over_prior", finite_or_null(each.deviation)},
          {"at_bound", each.at_bound}};
}

Json observable_json(const Calibration& result, Eigen::Index row) {
  const Fit& fit = result.fit;
  return {{"name", name_of(row)},
          {"unit", unit_of(row)},
          {"subjects", fit.data.count[static_cast<std::size_t>(row)]},
          {"mean", finite_or_null(fit.data.mean[row])},
          {"uncertainty", finite_or_null(std::sqrt(fit.data.covariance(row, row)))},
          {"before", finite_or_null(fit.before[row])},
          {"after", finite_or_null(fit.after[row])},
          {"after_without_shortcuts", finite_or_null(result.whole[row])}};
}

Json held_out_json(const HeldOut& held) {
  Json observables = Json::array();
  for (const Eigen::Index row : held.seen.present()) {
    observables.push_back({{"name", name_of(row)},
                           {"unit", unit_of(row)},
                           {"mean", finite_or_null(held.seen.mean[row])},
                           {"foretold", finite_or_null(held.foretold[row])}});
  }
  return {{"group", held.group},
          {"subjects", held.subjects},
          {"converged", held.converged},
          {"error_fitted", finite_or_null(held.error_fitted)},
          {"error_foretold", finite_or_null(held.error_foretold)},
          {"observables", observables}};
}

Json recording_json(const CalibratedRecording& recording) {
  Json json{{"file", recording.file},
            {"name", recording.subject.name},
            {"kind", recording.kind == Recording::Kind::measured ? "measured" : "reconstructed"},
            {"group", recording.subject.group},
            {"technique", recording.technique},
            {"force", name_of(recording.subject.seen.force)},
            {"source", recording.source},
            {"hash", recording.hash}};
  if (recording.subject.body_mass_index) { json["bmi_kg_per_m2"] = *recording.subject.body_mass_index; }
  return json;
}

Json correlation_json(const Fit& fit) {
  Json keys = Json::array();
  Json rows = Json::array();
  for (std::size_t n = 0; n < fit.told.size(); ++n) {
    keys.push_back(fit.parameters[fit.told[n]].parameter.key);
    const Eigen::VectorXd row = fit.correlation.row(static_cast<Eigen::Index>(n)).transpose();
    rows.push_back(std::vector<double>(row.begin(), row.end()));
  }
  return {{"parameters", keys}, {"matrix", rows}};
}

}  // namespace

std::string to_json(const CalibrationReport& report) {
  const Calibration& result = report.result;
  const Fit& fit = result.fit;
  Json json{{"schema", 1},
            {"verdict", calibration_verdict(report)},
            {"held", result.held()},
            {"scene", report.scene},
            {"scene_hash", report.scene_hash},
            {"converged", fit.converged},
            {"iterations", fit.iterations},
            {"simulations", result.simulations},
            {"misfit_before", fit.misfit_before},
            {"misfit_after", fit.misfit_after},
            {"interval_widening", fit.widening},
            {"shortcut_cost", finite_or_null(result.shortcut_cost())}};
  json["parameters"] = Json::array();
  for (const FittedParameter& each : fit.parameters) { json["parameters"].push_back(parameter_json(each)); }
  json["correlation"] = correlation_json(fit);
  json["observables"] = Json::array();
  for (const Eigen::Index row : fit.rows) { json["observables"].push_back(observable_json(result, row)); }
  json["profile"] = nullptr;
  if (!result.profile.value.empty()) {
    json["profile"] = {{"key", fit.parameters[result.profile.parameter].parameter.key},
                       {"value", result.profile.value},
                       {"growth", result.profile.growth}};
  }
  json["leave_one_group_out"] = Json::array();
  for (const HeldOut& held : result.held_out) { json["leave_one_group_out"].push_back(held_out_json(held)); }
  json["recordings"] = Json::array();
  for (const CalibratedRecording& each : report.recordings) {
    json["recordings"].push_back(recording_json(each));
  }
  json["warnings"] = calibration_warnings(report);
  return json.dump(2) + "\n";
}

}  // namespace palpate
