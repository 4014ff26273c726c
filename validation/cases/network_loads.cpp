// SPDX-License-Identifier: MIT
/// A load acts on the integrator steps that begin in [start, end): the impulse on a free node
/// counts them. Instants are whole numbers of a small unit here, so that the expected count is
/// exact.

#include <array>
#include <cmath>
#include <numbers>

#include "model/stepping/integrator.hpp"
#include "validation/cases/network_parts.hpp"
#include "validation/cases/network_support.hpp"

namespace palpate::networks {

namespace {

constexpr double force = 0.75;  ///< [N]
constexpr double mass = 0.25;   ///< [kg]

/// A tick, its substeps, and a load, in units of `unit` seconds.
struct Timing {
  const char* name;
  double unit;  ///< [s]
  long tick;
  int substeps;
  long ticks;
  double start;  ///< [s] as a person would write or compute it
  double end;
  long start_units;
  long end_units;
};

constexpr std::array timings{
    Timing{"aligned", 1e-3, 1, 1, 50, 0.01, 0.03, 10, 30},
    Timing{"from_the_beginning", 1e-3, 1, 1, 50, 0.0, 0.02, 0, 20},
    Timing{"sum_of_tenths", 0.1, 1, 1, 12, 0.1 + 0.2, 0.7, 3, 7},
    Timing{"product_of_tenths", 0.1, 1, 1, 12, 3 * 0.1, 7 * 0.1, 3, 7},
    Timing{"below_a_tenth", 0.1, 1, 1, 12, 0.3, 0.1 + 0.2 + 0.4, 3, 7},
    Timing{"between_steps", 1e-4, 10, 1, 50, 0.0103, 0.0297, 103, 297},
    Timing{"end_between_steps", 1e-4, 10, 1, 50, 0.01, 0.0201, 100, 201},
    Timing{"inside_one_step", 1e-4, 10, 1, 50, 0.0102, 0.0108, 102, 108},
    Timing{"one_step", 1e-3, 1, 1, 50, 0.017, 0.018, 17, 18},
    Timing{"on_substeps", 1e-4, 10, 10, 50, 0.0103, 0.0297, 103, 297},
    Timing{"between_substeps", 1e-5, 100, 10, 50, 0.01033, 0.02971, 1033, 2971},
    Timing{"thirds", 1.0 / 3000.0, 3, 3, 50, 7.0 / 3000.0, 0.031, 7, 93},
    Timing{"past_the_end", 1e-3, 1, 1, 50, 0.04, 1.0, 40, 1000}};

/// Steps n with start <= n h < end, in whole units.
long expected_steps(const Timing& timing) {
  const long total = timing.ticks * timing.substeps;
  long count = 0;
  for (long n = 0; n < total; ++n) {
    const long begin = n * timing.tick;  // in units / substeps
    if (begin >= timing.start_units * timing.substeps &&
        begin < timing.end_units * timing.substeps) {
      ++count;
    }
  }
  return count;
}

SpringNetwork one_node() {
  SpringNetwork network;
  network.rest_position = NodeVectors::Zero(3, 1);
  network.mass = Eigen::VectorXd::Constant(1, mass);
  network.fixed = {0};
  return network;
}

/// Velocity that a load leaves behind, over h force / mass: a number of steps.
double impulse_in_steps(const CaseContext& context, const std::string& scheme, const Timing& timing,
                        Profile profile) {
  const double tick = timing.unit * static_cast<double>(timing.tick);
  Scene scene = scene_of(scheme, tick, tick * static_cast<double>(timing.ticks), timing.substeps);
  scene.loads = {{.nodes = {0},
                  .force = {0.0, 0.0, force},
                  .start = timing.start,
                  .end = timing.end,
                  .profile = profile}};
  const SpringNetwork network = one_node();
  const Motion motion = simulate(context, scene, &network, {.velocity = true});
  return motion.velocity(2, motion.velocity.cols() - 1) * mass / (force * motion.h);
}

void judge_counts(const CaseContext& context, Outcome& outcome) {
  Table table{
      .id = "steps",
      .title = "Steps on which a load acts",
      .caption =
          "Impulse of a constant load over h F under Euler-Cromer, beside the number "
          "of steps that begin in [start, end).",
      .columns = {"load", "start (s)", "end (s)", "h (s)", "impulse (steps)", "expected (steps)"}};
  for (const Timing& timing : timings) {
    const auto expected = static_cast<double>(expected_steps(timing));
    const double steps = impulse_in_steps(context, "euler-cromer", timing, Profile::constant);
    const double rounding = epsilon * (expected + 4.0) * expected;
    outcome.judge({.name = std::string("impulse_error_") + timing.name,
                   .value = std::abs(steps - expected),
                   .unit = "steps",
                   .upper = rounding,
                   .bound_from = "an exact count; one rounding of the velocity per step"});
    table.rows.push_back({timing.name, timing.start, timing.end,
                          timing.unit * static_cast<double>(timing.tick) / timing.substeps, steps,
                          expected});
  }
  outcome.tables.push_back(std::move(table));
}

/// Every scheme gives a constant load the same impulse. A staggered scheme's velocity at an instant
/// is the mean of two, so only loads that have ended count.
void judge_schemes(const CaseContext& context, Outcome& outcome) {
  for (const IntegratorInfo* scheme : integrators()) {
    double error = 0.0;
    for (const Timing& timing : timings) {
      if (timing.end_units > timing.ticks * timing.tick) { continue; }
      const auto expected = static_cast<double>(expected_steps(timing));
      const double steps =
          impulse_in_steps(context, std::string(scheme->name), timing, Profile::constant);
      error = worse(error, std::abs(steps - expected));
    }
    outcome.judge({.name = "largest_impulse_error_" + std::string(scheme->name),
                   .value = error,
                   .unit = "steps",
                   .upper = 64.0 * epsilon * 200.0 * 200.0,
                   .bound_from = "an exact count of at most 200 steps; 64 roundings a step"});
  }
}

/// Sums of the other profiles over aligned steps have closed forms.
void judge_profiles(const CaseContext& context, Outcome& outcome) {
  const Timing& aligned = timings.front();
  const double n = 20.0;
  const double sine = 1.0 / std::tan(std::numbers::pi / (2.0 * n));  // sum of sin(pi k / n)
  const double ramp = (n - 1.0) / 2.0;                               // sum of k / n
  const auto judge = [&](const char* name, Profile profile, double expected) {
    const double steps = impulse_in_steps(context, "euler-cromer", aligned, profile);
    outcome.judge({.name = name,
                   .value = std::abs(steps / expected - 1.0),
                   .upper = 1e-14 * n,
                   .bound_from = "closed sum over the steps; a few roundings each"});
  };
  judge("half_sine_impulse_error", Profile::half_sine, sine);
  judge("ramp_impulse_error", Profile::ramp, ramp);
}

void measure(const CaseContext& context, Outcome& outcome) {
  judge_counts(context, outcome);
  judge_schemes(context, outcome);
  judge_profiles(context, outcome);
}

}  // namespace

std::vector<Case> load_cases() {
  return {{.name = "network/load-edges",
           .suite = "accuracy",
           .claim = "A load acts on exactly the integrator steps that begin in [start, end), "
                    "whatever rounding does to the instants.",
           .measure = measure,
           .weight = 0.1}};
}

}  // namespace palpate::networks
