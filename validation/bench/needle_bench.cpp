// SPDX-License-Identifier: MIT
/// A needle through ligament of published modulus on 1000 nodes, an implicit step a tick: what the slowest tick
/// costs on one core, and what the solver's tolerance does to the force.
#include <algorithm>
#include <cmath>

#include "model/stepping/simulation.hpp"
#include "validation/bench/bench_cases.hpp"
#include "validation/bench/interleaved.hpp"
#include "validation/cases/tool_setting.hpp"

namespace palpate::bench {

namespace {

constexpr int repeats = 9;
constexpr double tolerance = 1e-2;

struct Insertion {
  std::vector<double> force{};    ///< on the hand at every tick [N]
  std::vector<double> seconds{};  ///< of the processor, for every tick
  bool diverged = false;
};

/// 42.3 mm deep into a block of 10 x 10 x 10 nodes, and half a second of rest there.
Scene needle_scene(const CaseContext& context) {
  Scene scene = tools::seven_published_layers(10);
  scene.drive->depth = 0.0423;
  scene.simulation = {.duration = context.quick ? 0.6 : 2.6, .step = 1e-3};
  return scene;
}

Insertion insert(const Scene& scene) {
  Simulation simulation(scene);
  Insertion run;
  while (simulation.ticks() < simulation.tick_count() && !run.diverged) {
    const double begin = seconds_on(Clock::processor);
    run.diverged = simulation.tick() != StepStatus::ok;
    run.seconds.push_back(seconds_on(Clock::processor) - begin);
    run.force.push_back(simulation.tool().forces.total);
  }
  return run;
}

/// A run is the same work at the same tick every time: the least of several is what it costs.
Insertion insert_repeatedly(const Scene& scene) {
  Insertion least = insert(scene);
  for (int n = 1; n < repeats; ++n) {
    const Insertion again = insert(scene);
    for (std::size_t k = 0; k < std::min(least.seconds.size(), again.seconds.size()); ++k) {
      least.seconds[k] = std::min(least.seconds[k], again.seconds[k]);
    }
  }
  return least;
}

/// Over the peak, at every tick; NaN where a run ended early.
std::vector<double> errors(const Insertion& run, const Insertion& truth) {
  const double peak = *std::ranges::max_element(truth.force);
  std::vector<double> errors(truth.force.size(), std::nan(""));
  for (std::size_t k = 0; k < std::min(run.force.size(), truth.force.size()); ++k) {
    errors[k] = std::abs(run.force[k] - truth.force[k]) / peak;
  }
  return errors;
}

double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double value : values) { most = std::isnan(value) ? value : std::fmax(most, value); }
  return most;
}

void tell_times(const Insertion& run, const std::string& of, Outcome& outcome) {
  std::vector<double> sorted = run.seconds;
  std::ranges::sort(sorted);
  const auto share = [&](double part) {
    return 1e6 * sorted[static_cast<std::size_t>(part * static_cast<double>(sorted.size() - 1))];
  };
  outcome.timings.push_back({"median_tick_" + of, share(0.5), "us"});
  outcome.timings.push_back({"tick_of_a_hundred_" + of, share(0.99), "us"});
  outcome.timings.push_back({"worst_tick_" + of, share(1.0), "us"});
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
  const Insertion run = insert_repeatedly(scene);
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
