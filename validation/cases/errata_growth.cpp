// SPDX-License-Identifier: MIT
/// The errata that make a lattice diverge, judged by the rate at which the linearised printed
/// equations say it must.

#include <cmath>

#include "model/dynamics/network_builder.hpp"
#include "validation/cases/errata_parts.hpp"
#include "validation/cases/errata_pressed.hpp"

namespace palpate::errata {

namespace {

void judge_ratio(Outcome& outcome, const std::string& name, double value, double tolerance,
                 const std::string& from) {
  outcome.judge({.name = name,
                 .value = value,
                 .lower = 1.0 - tolerance,
                 .upper = 1.0 + tolerance,
                 .bound_from = from});
}

void judge_rate(Outcome& outcome, const std::string& name, const Rate& rate) {
  outcome.judge({.name = name + ": growth per second", .value = rate.measured, .unit = "1/s"});
  judge_ratio(outcome, name + ": growth over its prediction", rate.measured / rate.predicted, 1e-4,
              "eigenvalue of the linearised printed step; strains of 1e-4 bend it");
}

void judge_divergence(Outcome& outcome, const std::string& name, bool diverged) {
  outcome.judge({.name = name + ": diverges",
                 .value = diverged ? 1.0 : 0.0,
                 .lower = 1.0,
                 .bound_from = "a positive rate of growth"});
}

/// Long enough for every growing mode to leave all bounds.
Motion run_away(const CaseContext& context, const PrintedForm& printed, double seconds) {
  const Scene scene = pressed_scene(step, seconds, printed);
  const SpringNetwork network = build_network(scene);
  return simulate(context, scene, &network, {.every = 100});
}

void judge_runaway(const CaseContext& context, Outcome& outcome, const PrintedForm& printed,
                   const std::string& name, double seconds) {
  const Motion motion = run_away(context, printed, seconds);
  judge_divergence(outcome, name, motion.diverged);
  outcome.judge(
      {.name = name + ": out of all bounds at", .value = motion.diverged_at, .unit = "s"});
}

}  // namespace

Finding measure_sign(const CaseContext& context, Outcome& outcome) {
  const PrintedForm printed{.sign = true};
  const Rate rate = measure_rate(context, printed, step, step);
  judge_rate(outcome, "sign", rate);
  judge_ratio(outcome, "ARKODE on the printed equations: growth over its prediction",
              reference_rate(printed) / rate.motion, 1e-4,
              "eigenvalue of the linearised printed equations; strains of 1e-4 bend it");
  outcome.judge(
      {.name = "rate of the printed equations without steps", .value = rate.motion, .unit = "1/s"});
  judge_runaway(context, outcome, printed, "sign", 1.0);
  compare_pressed(context, outcome, printed, "sign");
  return {"sign",
          "Eqs. 11-13",
          "a stretched spring pushes its ends apart: every network diverges",
          "growth (1/s)",
          rate.measured,
          rate.predicted};
}

Finding measure_reversed(const CaseContext& context, Outcome& outcome) {
  const PrintedForm printed{.sign = true, .reversed = true};
  const Rate rate = measure_rate(context, printed, step, step);
  judge_rate(outcome, "reversed", rate);
  judge_ratio(outcome, "ARKODE on the printed equations: growth over its prediction",
              reference_rate(printed) / rate.motion, 1e-4,
              "eigenvalue of the linearised printed equations; strains of 1e-4 bend it");
  outcome.judge(
      {.name = "rate of the printed equations without steps", .value = rate.motion, .unit = "1/s"});
  judge_runaway(context, outcome, printed, "reversed", 1.0);
  compare_pressed(context, outcome, printed, "reversed");
  return {"sign, turned round",
          "Eqs. 11-13, force reversed",
          "the damper feeds energy in: every network with viscosity diverges",
          "growth (1/s)",
          rate.measured,
          rate.predicted};
}

Finding measure_no_time_step(const CaseContext& context, Outcome& outcome) {
  const PrintedForm printed{.no_time_step = true};
  const Rate rate = measure_rate(context, printed, step, 1.0);
  judge_rate(outcome, "no time step", rate);
  judge_runaway(context, outcome, printed, "no time step", duration);

  // A lattice a billion times softer has a stable step above 1 s: what is left of the erratum is a
  // clock that runs at one second per tick, to the last bit.
  Scene soft = pressed_scene(step, 100.0 * step, printed);
  soft.tissue.lattice.stiffness *= 1e-9;
  soft.tissue.lattice.viscosity *= 1e-6;
  soft.loads[0].force *= 1e-9;
  Scene seconds = soft;
  seconds.simulation.printed = {};
  seconds.simulation.step = 1.0;
  seconds.simulation.duration = 100.0;
  const SpringNetwork network = build_network(soft);
  const Motion ticks = simulate(context, soft, &network);
  const Motion slow = simulate(context, seconds, &network);
  const bool comparable = ticks.position.cols() == 101 && slow.position.cols() == 101 &&
                          ticks.position.allFinite() && slow.position.allFinite();
  const double difference =
      comparable ? (ticks.position - slow.position).cwiseAbs().maxCoeff() : std::nan("");
  outcome.judge({.name = "soft lattice: printed ticks less corrected steps of 1 s",
                 .value = difference,
                 .unit = "m",
                 .upper = 0.0,
                 .bound_from = "the same operations in the same order"});
  compare_pressed(context, outcome, printed, "no-time-step");
  outcome.notes.emplace_back(
      "Without the time step every tick advances the tissue by one second; only tissue whose "
      "fastest "
      "frequency is below 2 rad/s would survive it.");
  return {"no time step",
          "pseudo-code",
          "every tick is a step of 1 s: diverges at once",
          "log growth per tick (1)",
          rate.measured * step,
          rate.predicted * step};
}

Finding measure_all_printed(const CaseContext& context, Outcome& outcome) {
  // Eq. 9 divides by the tick while a step lasts one second, so damping is 1 / tick times itself.
  const PrintedForm printed = PrintedForm::all();
  const Rate rate = measure_rate(context, printed, step, 1.0, 1.0 / step);
  judge_rate(outcome, "all printed", rate);
  judge_runaway(context, outcome, printed, "all printed", duration);
  compare_pressed(context, outcome, printed, "all-printed");
  return {"all as printed",          "Eqs. 9-14 and pseudo-code", "diverges within a few ticks",
          "log growth per tick (1)", rate.measured * step,        rate.predicted * step};
}

}  // namespace palpate::errata
