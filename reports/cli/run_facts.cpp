// SPDX-License-Identifier: MIT
#include "reports/cli/run_facts.hpp"

#include <cmath>

#include "fixtures/io/file_bytes.hpp"
#include "reports/markup.hpp"
#include "reports/run_report.hpp"

namespace palpate::cli {

namespace {

std::string with(double value, const char* unit) { return short_number(value) + " " + unit; }

std::vector<Fact> scene_facts(const LoadedScene& loaded) {
  const Simulation& simulation = loaded.simulation;
  const auto* network = dynamic_cast<const NetworkProblem*>(&simulation.problem());
  if (network == nullptr) { return {{"tissue", "one spring-mass-damper", ""}}; }
  const auto nodes = network->network().node_count();
  return {{"nodes", std::to_string(nodes),
           std::to_string(network->free_nodes().size()) + " free"},
          {"springs", std::to_string(network->network().springs.size()), ""}};
}

void add_step_facts(std::vector<Fact>& facts, const StepPlan& plan) {
  const double limit = plan.stable_step.at(std::string(plan.integrator->name));
  facts.push_back({"integrator", std::string(plan.integrator->name), plan.integrator_reason});
  facts.push_back({"substeps a tick", std::to_string(plan.substeps), plan.substeps_reason});
  facts.push_back({"step", with(plan.h, "s"),
                   std::isfinite(limit) ? "stable below " + with(limit, "s") : "no stability limit"});
  facts.push_back({"highest frequency", with(plan.bounds.omega_estimate, "rad/s"),
                   "guaranteed below " + with(plan.bounds.omega_upper, "rad/s")});
  facts.push_back({"kernel", plan.kernel, ""});
}

void add_cost_facts(std::vector<Fact>& facts, const LoadedScene& loaded, const Run& run) {
  const double simulated = run.trace.time.back();
  facts.push_back({"wall time", with(run.seconds, "s"),
                   "for " + with(simulated, "s") + " simulated; slowest tick " +
                       with(1e3 * run.slowest_tick, "ms")});
  facts.push_back({"cost", with(run.ns_per_spring_step(loaded.simulation.spring_count()), "ns"),
                   "per spring and step"});
  facts.push_back({"energy", with(run.energy.initial, "J") + " to " + with(run.energy.final, "J"),
                   "at most " + with(run.energy.maximum, "J")});
}

}  // namespace

void write_run_report(const std::filesystem::path& folder, const LoadedScene& loaded,
                      const Run& run, const std::map<std::string, std::string>& provenance) {
  const StepPlan& plan = loaded.simulation.plan();
  RunReport report;
  report.title = loaded.file.scene.title.empty() ? "Palpate run" : loaded.file.scene.title;
  report.held = !run.diverged;
  report.verdict = run.diverged ? "Diverged at t = " + with(run.diverged_at, "s")
                   : run.interrupted ? "Interrupted at t = " + with(run.trace.time.back(), "s")
                                     : "Ran to t = " + with(run.trace.time.back(), "s");
  report.detail = run.diverged ? "The motion left every bound; the traces are kept up to there."
                               : std::to_string(run.ticks) + " ticks, every state finite and in bounds.";
  report.facts = scene_facts(loaded);
  add_step_facts(report.facts, plan);
  add_cost_facts(report.facts, loaded, run);
  report.skipped = plan.skipped;
  report.warnings = plan.warnings;
  if (run.zero_length_springs > 0) {
    report.warnings.push_back(std::to_string(run.zero_length_springs) +
                              " springs have no length and exert no force");
  }
  for (const auto& [name, value] : provenance) { report.provenance.push_back({name, value, ""}); }
  report.command = "palpate run " + loaded.file.inputs.front().filename().string();
  io::replace_file(folder / "report.html", to_html(report, run.trace));
}

}  // namespace palpate::cli
