// SPDX-License-Identifier: MIT
/// What accuracy costs, counted: evaluations of the force are the same on every machine, so that a gate can hold
/// them.
#include <array>
#include <cmath>

#include "validation/bench/bench_cases.hpp"
#include "validation/bench/frontier.hpp"
#include "validation/bench/model_runs.hpp"
#include "validation/cases/tool_setting.hpp"
#include "validation/number_words.hpp"

namespace palpate::bench {

namespace {

/// A scene whose explicit schemes are compared, each with 1, 2, 4 ... substeps.
struct Frontier {
  Scene scene{};
  std::vector<std::string> schemes{"euler", "euler-cromer", "velocity-verlet", "rk4"};
  int least_substeps = 1;
  int most_substeps = 64;
  std::vector<double> costs{};  ///< evaluations for which digits are told
  Truth truth{};
  std::function<Run(const Scene&)> here{};
};

std::vector<Effort> efforts_of(const Frontier& frontier) {
  std::vector<Effort> efforts;
  for (const std::string& scheme : frontier.schemes) {
    for (int substeps = frontier.least_substeps; substeps <= frontier.most_substeps; substeps *= 2) {
      Scene scene = frontier.scene;
      scene.simulation.integrator = scheme;
      scene.simulation.substeps = substeps;
      const Run run = frontier.here(scene);
      if (run.failed) { continue; }
      const double error = errors_of(run, frontier.truth).tool;
      if (!(error < 1.0)) { continue; }
      efforts.push_back({.method = scheme, .cost = static_cast<double>(run.evaluations), .error = error});
      if (error < 10.0 * frontier.truth.floor) { break; }
    }
  }
  return efforts;
}

Table table_of(const std::vector<Effort>& efforts) {
  Table table{.id = "efforts",
              .title = "Evaluations and errors",
              .caption = "The largest error at the tool over its peak.",
              .columns = {"scheme", "evaluations of the force", "error"}};
  for (const Effort& each : efforts) { table.rows.push_back({each.method, each.cost, each.error}); }
  return table;
}

void judge(const Frontier& frontier, Outcome& outcome) {
  const std::vector<Effort> efforts = efforts_of(frontier);
  outcome.judge({.name = "floor_of_the_reference",
                 .value = frontier.truth.floor,
                 .upper = 1e-5,
                 .bound_from = "a tenth of the smallest error that is asked for"});
  for (const double error : {1e-2, 1e-3, 1e-4}) {
    outcome.judge({.name = "evaluations_at_" + plain_number(error) + "_of_the_peak",
                   .value = cost_at(efforts, error),
                   .unit = "evaluations"});
  }
  for (const double cost : frontier.costs) {
    outcome.judge({.name = "digits_after_" + plain_number(cost, 6) + "_evaluations",
                   .value = digits_at(efforts, cost),
                   .unit = "digits"});
  }
  outcome.tables.push_back(table_of(efforts));
}

void judge_point(const CaseContext& context, Frontier frontier, int node,
                 const std::array<const char*, 2>& references, Outcome& outcome) {
  const PointScene point(context, frontier.scene, node);
  const reference::Tolerance tight{.relative = 1e-9, .position_scale = 1e-3, .velocity_scale = 1e-2};
  frontier.truth = truth_of(point.there(references[0], tight), point.there(references[1], tight));
  frontier.here = [&](const Scene& scene) { return point.here(scene); };
  judge(frontier, outcome);
}

void measure_oscillator(const CaseContext& context, Outcome& outcome) {
  Frontier frontier;
  frontier.costs = {400.0, 1600.0};
  frontier.scene.simulation = {.duration = 25.0, .step = 0.25};
  frontier.scene.tissue.source = Source::oscillator;
  judge_point(context, frontier, 0, {"modal", "arkode-fehlberg-7-8"}, outcome);
}

void measure_cube(const CaseContext& context, Outcome& outcome) {
  Frontier frontier;
  frontier.scene = s26_scene(6);
  frontier.costs = {400.0, 1600.0};
  judge_point(context, frontier, frontier.scene.loads.front().nodes.front(), {"arkode-fehlberg-7-8", "cvode-adams"},
              outcome);
}

/// The force on the hand, but within two ticks of an event, where it jumps.
void measure_needle(const CaseContext& context, Outcome& outcome) {
  Frontier frontier;
  frontier.scene = tools::seven_soft_layers();
  frontier.least_substeps = 8;
  frontier.costs = {2400.0, 9600.0};
  frontier.scene.simulation = {.duration = 0.15, .step = 1e-3};
  const NeedleReference finest = needle_there(frontier.scene, 1e-9);
  frontier.truth = truth_of(finest.run, needle_there(frontier.scene, 1e-8).run, finest.jumps);
  frontier.here = [&](const Scene& scene) { return needle_here(context, scene); };
  judge(frontier, outcome);
}

Case frontier_case(const std::string& scene, void (*measure)(const CaseContext&, Outcome&)) {
  return {
      .name = "bench/frontier/" + scene,
      .suite = "timing",
      .claim =
          "What an error costs in evaluations of the force, and what they buy, is known to a tenth of the smallest "
          "error that is asked for.",
      .measure = measure,
      .weight = 10.0};
}

}  // namespace

std::vector<Case> frontier_cases() {
  return {frontier_case("oscillator", measure_oscillator), frontier_case("cube", measure_cube),
          frontier_case("needle", measure_needle)};
}

}  // namespace palpate::bench
