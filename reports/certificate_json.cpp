// SPDX-License-Identifier: MIT
#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "reports/certificate_report.hpp"
#include "reports/json_number.hpp"
#include "reports/shown_units.hpp"
#include "validation/certificate/miss_bound.hpp"

namespace palpate {
namespace {

using namespace certificate;
using Json = nlohmann::ordered_json;

Json number_or_null(const std::optional<double>& value) {
  return value ? finite_or_null(us * *value) : Json(nullptr);
}

Json times_json(const CertificateReport& report, const LatencyHistogram& times, const Peak& worst) {
  if (times.count() == 0) { return nullptr; }
  Json json{{"min", us * times.minimum()}};
  for (const auto& [name, share] : shown_percentiles) {
    json[name] = number_or_null(times.percentile(share));
  }
  json["max"] = us * times.maximum();
  json["max_at_tick"] = worst.tick;
  json["max_at_scene_s"] = worst.moment.scene_time;
  const std::string event = happening_at(report, worst.moment);
  json["max_at_event"] = event.empty() ? Json(nullptr) : Json(event);
  return json;
}

Json phase_json(const CertificateReport& report, const Phase& phase) {
  const LoopRecord& record = phase.record;
  return {{"ticks", record.ticks()},
          {"misses", record.misses.count()},
          {"miss_probability_upper_95", miss_probability_upper(record.misses.count(), record.ticks())},
          {"longest_miss_run", record.misses.longest_run()},
          {"longest_recovery_us", us * record.misses.longest_recovery()},
          {"wakeup_us", times_json(report, record.wakeup, record.worst_wakeup)},
          {"compute_us", times_json(report, record.compute, record.worst_compute)},
          {"response_us", times_json(report, record.response, record.worst_response)},
          {"given_up", phase.hopeless},
          {"seconds", phase.seconds},
          {"restarts", phase.restarts},
          {"paused_s", phase.paused},
          {"minor_faults", phase.counts.minor_faults},
          {"major_faults", phase.counts.major_faults},
          {"voluntary_switches", phase.counts.voluntary_switches},
          {"involuntary_switches", phase.counts.involuntary_switches},
          {"stolen_s", phase.times.stolen},
          {"interrupts_s", phase.times.interrupts},
          {"other_processors_busy_s", phase.times.others}};
}

Json tail_json(const Tail& tail) {
  Json json{{"refused", tail.refusal.empty() ? Json(nullptr) : Json(tail.refusal)},
            {"checks", Json::array()},
            {"fits", Json::array()},
            {"levels", Json::array()},
            {"miss_probability", tail.beyond_deadline ? Json(*tail.beyond_deadline) : Json(nullptr)}};
  for (const TailCheck& check : tail.checks) {
    json["checks"].push_back({{"name", check.name},
                              {"claim", check.claim},
                              {"value", finite_or_null(check.value)},
                              {"lower", finite_or_null(check.lower)},
                              {"upper", finite_or_null(check.upper)},
                              {"holds", check.holds()}});
  }
  for (const ThresholdFit& fit : tail.fits) {
    json["fits"].push_back({{"threshold_us", us * fit.threshold},
                            {"exceedances", fit.fit.count},
                            {"shape", fit.fit.shape},
                            {"scale_us", us * fit.fit.scale}});
  }
  for (const ReturnLevel& level : tail.levels) {
    json["levels"].push_back({{"probability", level.probability},
                              {"response_us", us * level.value},
                              {"lower_us", us * level.lower},
                              {"upper_us", finite_or_null(us * level.upper)}});
  }
  return json;
}

Json budget_json(const CertificateReport& report) {
  const ComputeBudget& budget = report.result.budget;
  const double deadline = report.result.claim.deadline;
  const auto cycles = [&](double seconds) {
    return report.cycles_per_second ? Json(seconds * *report.cycles_per_second) : Json(nullptr);
  };
  Json json{
      {"statement", budget_words(report.result)},
      {"worst_us", budget.provocations.empty() ? Json(nullptr) : Json(us * budget.worst())},
      {"worst_cycles", budget.provocations.empty() ? Json(nullptr) : cycles(budget.worst())},
      {"deadline_cycles", cycles(deadline)},
      {"cycles_per_second", report.cycles_per_second ? Json(*report.cycles_per_second) : Json(nullptr)},
      {"worst_instructions", budget.worst_instructions ? Json(*budget.worst_instructions) : Json(nullptr)},
      {"not_counted", budget.worst_instructions ? Json(nullptr) : Json(report.not_counted)},
      {"provocations", Json::array()}};
  for (const Provocation& each : budget.provocations) {
    json["provocations"].push_back({{"name", each.name},
                                    {"what", each.what},
                                    {"scene_s", each.scene_time},
                                    {"processor_us", us * each.processor},
                                    {"wall_us", us * each.wall},
                                    {"share_of_deadline", each.processor / deadline},
                                    {"ticks", each.ticks},
                                    {"repetitions", each.repetitions}});
  }
  return json;
}

Json missed_tick_json(const std::optional<MissedTick>& missed) {
  constexpr double mj = 1e3;
  if (!missed) { return nullptr; }
  return {{"stiffness_n_per_m", missed->stiffness},
          {"speed_m_per_s", missed->speed},
          {"bound_mj", mj * missed->bound},
          {"sampled_bound_mj", mj * missed->sampled_bound},
          {"measured_mj", missed->measured ? Json(mj * *missed->measured) : Json(nullptr)},
          {"measured_at_s", missed->measured ? Json(missed->measured_at) : Json(nullptr)}};
}

Json environment_json(const std::vector<EnvironmentFact>& facts) {
  Json json = Json::object();
  for (const EnvironmentFact& fact : facts) {
    json[fact.key] = std::visit(
        [](const auto& value) -> Json {
          if constexpr (std::is_same_v<std::decay_t<decltype(value)>, std::monostate>) {
            return nullptr;
          } else {
            return value;
          }
        },
        fact.value);
  }
  return json;
}

Json loads_json(const CertificateReport& report) {
  Json loads = Json::array();
  for (const LoadResult& load : report.result.loads) {
    loads.push_back({{"load", load.load},
                     {"control", phase_json(report, load.control)},
                     {"scene", phase_json(report, load.scene)},
                     {"tail", tail_json(load.tail)}});
  }
  return loads;
}

}  // namespace

std::string to_json(const CertificateReport& report) {
  const Certificate& all = report.result;
  const Judgement judgement = judge(all);
  const LoadResult nothing("", all.claim.deadline);
  const LoadResult& worst = all.worst() != nullptr ? *all.worst() : nothing;
  Json json{{"schema", 1},
            {"verdict", name_of(judgement.verdict)},
            {"reason", judgement.reason},
            {"interrupted", all.interrupted},
            {"scene", report.file},
            {"title", report.title},
            {"scene_hash", report.scene_hash},
            {"rate_hz", all.claim.rate},
            {"deadline_us", us * all.claim.deadline},
            {"duration_s", all.claim.duration},
            {"confidence", 0.95},
            {"load", worst.load.empty() ? Json(nullptr) : Json(worst.load)}};
  json.update(phase_json(report, worst.scene));
  json["control"] = phase_json(report, worst.control);
  json["tail"] = tail_json(worst.tail);
  json["compute_budget"] = budget_json(report);
  json["missed_tick"] = missed_tick_json(all.missed_tick);
  json["environment"] = environment_json(report.environment);
  json["loads"] = loads_json(report);
  json["notes"] = all.notes;
  json["command"] = report.command;
  json["provenance"] = report.provenance;
  return json.dump(2) + "\n";
}

}  // namespace palpate
