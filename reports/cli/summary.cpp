// SPDX-License-Identifier: MIT
#include "reports/cli/summary.hpp"

#include "reports/json_number.hpp"

namespace palpate::cli {

namespace {

using Json = nlohmann::ordered_json;

Json device_json(const FalconFacts& facts) {
  Json json{{"ticks", facts.ticks},
            {"saturated_ticks", facts.saturated},
            {"unanswered_requests", facts.unanswered},
            {"unhomed_ticks", facts.unhomed},
            {"largest_requested_n", facts.largest_requested},
            {"largest_delivered_n", facts.largest_delivered},
            {"axial_limit_n", facts.axial_force},
            {"weakest_limit_n", facts.weakest_force},
            {"least_energy_j", facts.least_energy},
            {"least_energy_at_s", facts.least_energy_at},
            {"taken_by_controller_j", facts.taken_by_controller},
            {"reaction_s", facts.reaction}};
  if (facts.lost_resistance_at) {
    json["lost_resistance_at_s"] = *facts.lost_resistance_at;
    json["overshoot_m"] = facts.overshoot;
  }
  return json;
}

Json real_time_json(const device::DeadlineFacts& facts) {
  return {{"ticks", facts.ticks},
          {"missed", facts.missed},
          {"worst_wake_s", facts.worst_wake},
          {"worst_lateness_s", facts.worst_lateness}};
}

}  // namespace

std::string summary_json(const LoadedScene& loaded, const Run& run) {
  const Simulation& simulation = loaded.simulation;
  const StepPlan& plan = simulation.plan();
  const auto* network = dynamic_cast<const NetworkProblem*>(&simulation.problem());
  const std::size_t springs = network != nullptr ? network->network().springs.size() : 1;
  Json json;
  json["schema"] = 1;
  json["title"] = loaded.file.scene.title;
  json["status"] = run.diverged ? "diverged" : run.interrupted ? "interrupted" : "ok";
  if (run.diverged) { json["diverged_at_s"] = run.diverged_at; }
  json["nodes"] = network != nullptr ? network->network().node_count() : 1;
  json["springs"] = springs;
  json["ticks"] = run.ticks;
  json["steps"] = run.steps;
  json["integrator"] = plan.integrator->name;
  json["integrator_reason"] = plan.integrator_reason;
  json["substeps"] = plan.substeps;
  json["integrator_step_s"] = plan.h;
  json["omega_max_rad_per_s"] = plan.bounds.omega_estimate;
  json["h_omega_max"] = plan.h * plan.bounds.omega_estimate;
  json["load_s"] = loaded.load_seconds;
  json["wall_s"] = run.seconds;
  json["slowest_tick_s"] = run.slowest_tick;
  json["ns_per_spring_step"] = run.ns_per_spring_step(simulation.spring_count());
  json["kernel"] = plan.kernel;
  if (plan.sleep_force > 0.0) { json["awake_share"] = simulation.awake_share(); }
  json["skipped"] = plan.skipped;
  json["warnings"] = plan.warnings;
  json["zero_length_springs"] = run.zero_length_springs;
  json["energy"] = {{"initial_j", json_number(run.energy.initial)},
                    {"final_j", json_number(run.energy.final)},
                    {"max_j", json_number(run.energy.maximum)}};
  if (run.falcon) { json["device"] = device_json(*run.falcon); }
  if (run.real_time) { json["real_time"] = real_time_json(*run.real_time); }
  json["events"] = Json::array();
  for (const Event& event : run.trace.events) {
    json["events"].push_back(
        {{"time_s", event.time}, {"kind", event.kind}, {"detail", event.detail}});
  }
  return json.dump(2) + "\n";
}

}  // namespace palpate::cli
