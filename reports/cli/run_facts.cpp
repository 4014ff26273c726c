// SPDX-License-Identifier: MIT
#include "reports/cli/run_facts.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "fixtures/io/file_bytes.hpp"
#include "reports/falcon_report.hpp"
#include "reports/markup.hpp"
#include "reports/patient_report.hpp"
#include "reports/run_report.hpp"
#include "reports/tool_facts.hpp"
#include "reports/view_skin.hpp"

namespace palpate::cli {

namespace {

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
  facts.push_back({"step", quantity(plan.h, "s"),
                   std::isfinite(limit) ? "stable below " + quantity(limit, "s") : "no stability limit"});
  facts.push_back({"highest frequency", quantity(plan.bounds.omega_estimate, "rad/s"),
                   "guaranteed below " + quantity(plan.bounds.omega_upper, "rad/s")});
  facts.push_back({"kernel", plan.kernel, ""});
}

/// What a tick takes of the time that it has in a haptic loop.
Fact tick_cost(const StepPlan& plan, const Run& run) {
  const double tick = plan.h * plan.substeps;
  const double mean = run.ticks > 0 ? run.seconds / static_cast<double>(run.ticks) : 0.0;
  return {"time for a tick", quantity(1e3 * mean, "ms"),
          short_number(100.0 * mean / tick, 3) + " % of its " + quantity(1e3 * tick, "ms") + ", with " +
              std::to_string(plan.substeps) + (plan.substeps == 1 ? " step of " : " steps of ") +
              std::string(plan.integrator->name) + "; the slowest took " +
              quantity(1e3 * run.slowest_tick, "ms")};
}

/// How well ticks kept to the wall clock.
Fact punctuality(const device::DeadlineFacts& facts) {
  return {"ticks too late", std::to_string(facts.missed),
          "of " + std::to_string(facts.ticks) + ", by a period or more; latest by " +
              quantity(1e3 * facts.worst_lateness, "ms") + ", after a sleep by " +
              quantity(1e3 * facts.worst_wake, "ms")};
}

void add_cost_facts(std::vector<Fact>& facts, const LoadedScene& loaded, const Run& run) {
  const double simulated = run.trace.time.back();
  facts.push_back({"wall time", quantity(run.seconds, "s"),
                   "for " + quantity(simulated, "s") + " simulated; slowest tick " +
                       quantity(1e3 * run.slowest_tick, "ms")});
  facts.push_back({"cost", quantity(run.ns_per_spring_step(loaded.simulation.spring_count()), "ns"),
                   "per spring and step"});
  facts.push_back({"energy", quantity(run.energy.initial, "J") + " to " + quantity(run.energy.final, "J"),
                   "at most " + quantity(run.energy.maximum, "J")});
}

void add_view(RunReport& report, const RunPage& page) {
  const auto* network = dynamic_cast<const NetworkProblem*>(&page.loaded.simulation.problem());
  if (network == nullptr) { return; }
  if (page.no_view.empty()) {
    const Scene& scene = page.loaded.file.scene;
    std::vector<std::string> notes;
    std::vector<ViewSurface> surfaces;
    if (std::optional<ViewSurface> skin = view_of_skin(scene, notes)) { surfaces.push_back(std::move(*skin)); }
    report.view = make_view({scene, *network, page.run.trace, page.run.moments, std::move(surfaces)});
    if (report.view) { report.view->notes.insert(report.view->notes.end(), notes.begin(), notes.end()); }
  }
  if (!report.view) {
    report.skipped.push_back("view in three dimensions: " + (page.no_view.empty() ? "no frames are kept" : page.no_view));
  }
}

}  // namespace

void write_run_report(const std::filesystem::path& folder, const RunPage& page) {
  const auto& [loaded, run, palpation, provenance, no_view] = page;
  const StepPlan& plan = loaded.simulation.plan();
  RunReport report;
  report.title = loaded.file.scene.title.empty() ? "Palpate run" : loaded.file.scene.title;
  report.held = !run.diverged;
  report.verdict = run.diverged ? "Diverged at t = " + quantity(run.diverged_at, "s")
                   : run.interrupted ? "Interrupted at t = " + quantity(run.trace.time.back(), "s")
                                     : "Ran to t = " + quantity(run.trace.time.back(), "s");
  report.detail = run.diverged ? "The motion left every bound; the traces are kept up to there."
                               : std::to_string(run.ticks) + " ticks, every state finite and in bounds.";
  report.facts = tool_facts(run.trace);
  if (run.falcon) {
    std::ranges::move(falcon_fact_list(*run.falcon), std::back_inserter(report.facts));
  }
  if (!report.facts.empty()) { report.facts.push_back(tick_cost(plan, run)); }
  if (run.real_time) { report.facts.push_back(punctuality(*run.real_time)); }
  std::ranges::move(scene_facts(loaded), std::back_inserter(report.facts));
  std::ranges::move(patient_facts(loaded.file.scene), std::back_inserter(report.facts));
  add_step_facts(report.facts, plan);
  add_cost_facts(report.facts, loaded, run);
  report.skipped = plan.skipped;
  add_view(report, page);
  report.warnings = plan.warnings;
  std::ranges::copy(palpation.warnings, std::back_inserter(report.warnings));
  report.tool_figures = falcon_figures(run.trace);
  if (run.falcon) { report.tool_figures.push_back(force_reach_figure(*run.falcon)); }
  if (palpation.figure) { report.tool_figures.push_back(*palpation.figure); }
  std::ranges::move(lookup_figures(loaded.file.scene), std::back_inserter(report.tool_figures));
  if (run.zero_length_springs > 0) {
    report.warnings.push_back(std::to_string(run.zero_length_springs) +
                              " springs have no length and exert no force");
  }
  for (const auto& [name, value] : provenance) { report.provenance.push_back({name, value, ""}); }
  report.command = "palpate run " + loaded.file.inputs.front().filename().string();
  io::replace_file(folder / "report.html", to_html(report, run.trace));
}

}  // namespace palpate::cli
