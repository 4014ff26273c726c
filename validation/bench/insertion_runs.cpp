// SPDX-License-Identifier: MIT
#include "validation/bench/insertion_runs.hpp"

#include <algorithm>
#include <cmath>

#include "model/stepping/simulation.hpp"
#include "validation/bench/interleaved.hpp"

namespace palpate::bench {

Insertion insert(const Scene& scene) {
  Insertion run;
  const double start = seconds_on(Clock::processor);
  Simulation simulation(scene);
  run.loading = seconds_on(Clock::processor) - start;
  while (simulation.ticks() < simulation.tick_count() && !run.diverged) {
    const double begin = seconds_on(Clock::processor);
    run.diverged = simulation.tick() != StepStatus::ok;
    run.seconds.push_back(seconds_on(Clock::processor) - begin);
    run.force.push_back(simulation.tool().forces.total);
  }
  return run;
}

Insertion insert_repeatedly(const Scene& scene, int repeats) {
  Insertion least = insert(scene);
  for (int n = 1; n < repeats; ++n) {
    const Insertion again = insert(scene);
    least.loading = std::min(least.loading, again.loading);
    for (std::size_t k = 0; k < std::min(least.seconds.size(), again.seconds.size()); ++k) {
      least.seconds[k] = std::min(least.seconds[k], again.seconds[k]);
    }
  }
  return least;
}

std::vector<double> errors(const Insertion& run, const Insertion& truth) {
  const double peak = *std::ranges::max_element(truth.force);
  std::vector<double> errors(truth.force.size(), std::nan(""));
  for (std::size_t k = 0; k < std::min(run.force.size(), truth.force.size()); ++k) {
    errors[k] = std::abs(run.force[k] - truth.force[k]) / peak;
  }
  return errors;
}

std::vector<double> errors_within_a_tick(const Insertion& run, const Insertion& truth) {
  const double peak = *std::ranges::max_element(truth.force);
  std::vector<double> errors(truth.force.size(), std::nan(""));
  for (std::size_t k = 0; k < std::min(run.force.size(), truth.force.size()); ++k) {
    const auto begin = truth.force.begin() + static_cast<std::ptrdiff_t>(k > 0 ? k - 1 : 0);
    const auto end = truth.force.begin() + static_cast<std::ptrdiff_t>(std::min(k + 2, truth.force.size()));
    const auto [low, high] = std::minmax_element(begin, end);
    errors[k] = std::abs(run.force[k] - std::clamp(run.force[k], *low, *high)) / peak;
  }
  return errors;
}

double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double value : values) { most = std::isnan(value) ? value : std::fmax(most, value); }
  return most;
}

double ticks_within(const Insertion& run, double share) {
  std::vector<double> sorted = run.seconds;
  std::ranges::sort(sorted);
  return 1e6 * sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

void tell_times(const Insertion& run, const std::string& of, Outcome& outcome) {
  outcome.timings.push_back({"median_tick_" + of, ticks_within(run, 0.5), "us"});
  outcome.timings.push_back({"tick_of_a_hundred_" + of, ticks_within(run, 0.99), "us"});
  outcome.timings.push_back({"worst_tick_" + of, ticks_within(run, 1.0), "us"});
}

}  // namespace palpate::bench
