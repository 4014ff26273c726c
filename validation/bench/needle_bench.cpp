// SPDX-License-Identifier: MIT
/// A needle through ligament of published modulus on 1000 nodes, an implicit step a tick: what the slowest tick
/// costs on one core, and what the solver's tolerance does to the force.
#include <algorithm>

#include "validation/bench/bench_cases.hpp"
#include "validation/bench/insertion_runs.hpp"
#include "validation/cases/tool_setting.hpp"

namespace palpate::bench {

namespace {

constexpr int repeats = 9;
constexpr double tolerance = 1e-2;

/// 42.3 mm deep into a block of 10 x 10 x 10 nodes, and half a second of rest there.
Scene needle_scene(const CaseContext& context) {
  Scene scene = tools::seven_published_layers(10);
  scene.drive->depth = 0.0423;
  scene.simulation = {.duration = context.quick ? 0.6 : 2.6, .step = 1e-3};
  return scene;
}

void judge_force(const CaseContext& context, const Scene& scene, const Insertion& run, Outcome& outcome) {
  Scene exact = scene;
  exact.simulation.solver_tolerance = 0.0;
  const Insertion solved = insert(exact);
  tell_times(solved, "solved_to_rounding", outcome);
  outcome.judge({.name = "force_error_of_the_tolerance_over_peak",
                 .value = largest(errors(run, solved)),
                 .upper = 0.01,
                 .bound_from = "wanted: 1 % of the largest force, against the same steps solved to rounding"});
  exact.simulation.integrator = "velocity-verlet";
  const std::vector<double> apart = errors(run, insert(exact));
  const auto late = std::ranges::count_if(apart, [](double error) { return !(error <= 0.01); });
  // In a quick run the tip does not get beyond the interspinous ligament.
  outcome.judge({.name = "ticks_more_than_1_percent_from_explicit_steps",
                 .value = static_cast<double>(late),
                 .upper = context.quick ? 2.0 : 3.0,
                 .bound_from = "a step sees a harder layer when it ends: one tick for each of the three"});
}

void measure(const CaseContext& context, Outcome& outcome) {
  Scene scene = needle_scene(context);
  scene.simulation.solver_tolerance = tolerance;
  const Insertion run = insert_repeatedly(scene, repeats);
  outcome.judge({.name = "diverged", .value = run.diverged ? 1.0 : 0.0, .upper = 0.0,
                 .bound_from = "stable at ticks of 1 ms"});
  outcome.judge({.name = "worst_tick",
                 .value = 1e6 * largest(run.seconds),
                 .unit = "us",
                 .upper = 250.0,
                 .bound_from = "wanted: a quarter of the period of a loop of 1 kHz"});
  tell_times(run, "at_tolerance_0.01", outcome);
  judge_force(context, scene, run, outcome);
}

}  // namespace

std::vector<Case> needle_cases() {
  return {{.name = "bench/stiff-needle",
           .suite = "timing",
           .claim = "A needle in ligament of 15 MPa on 1000 nodes takes at most a quarter of every tick of 1 ms, "
                    "with the force within 1 % of its peak.",
           .measure = measure,
           .weight = 30.0}};
}

}  // namespace palpate::bench
