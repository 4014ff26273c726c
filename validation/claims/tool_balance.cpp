// SPDX-License-Identifier: MIT
/// Balances at every tick of an insertion: parts of the force, momentum, energy.

#include "model/tissue/network_builder.hpp"
#include "validation/claims/groups.hpp"
#include "validation/claims/tool_fixture.hpp"

namespace palpate::tools {

namespace {

void measure_parts(const CaseContext& context, Outcome& outcome) {
  Scene scene = seven_soft_layers();
  scene.simulation = {.duration = 1.15, .step = 1e-3, .integrator = "velocity-verlet"};
  const auto [run, tool] = insert(context, scene);
  Largest sum;
  Largest applied;
  Largest above;
  Largest peak;
  for (std::size_t n = 0; n < tool.size(); ++n) {
    const ToolForces& f = tool[n].forces;
    sum.add(std::abs(f.total - (f.cutting + f.friction + f.stiffness)));
    applied.add(std::abs(f.applied - f.total));
    above.add(std::max(0.0, std::max(f.cutting, f.stiffness) - 1.2));
    peak.add(std::abs(f.total));
  }
  const std::string rounding = "Eq. 2: nothing but rounding";
  outcome.judge_at_most("largest_difference_of_parts_and_total", sum.value(), 4e-16 * 4.0, rounding,
                        "N");
  outcome.judge_at_most("largest_difference_of_applied_and_total", applied.value(), 0.0,
                        "a prescribed drive applies what resists it", "N");
  outcome.judge_at_most("tip_force_above_the_strongest_cutting_force", above.value(), 0.0,
                        "law: the tip cuts before it pushes harder", "N");
  outcome.judge_equal("samples", tool.size(), 1151.0, "one a tick and the beginning");
  outcome.judge_between("peak_force", peak.value(), 1.2, 1.2 + 0.5,
                        "cutting force of the flavum and the friction of the whole track", "N");
}

/// Euler-Cromer moves momentum by exactly h times the forces at the beginning of a step.
void measure_momentum(const CaseContext& context, Outcome& outcome) {
  Scene scene = seven_soft_layers();
  const double h = 1e-5;
  scene.simulation = {.duration = 0.4, .step = h, .substeps = 1, .integrator = "euler-cromer"};
  const auto [run, run_tool] =
      insert(context, scene, {.position = true, .velocity = true, .energy = true});
  const NetworkProblem problem(build_network(scene));
  Eigen::VectorXd force(problem.dof());
  Largest worst;
  Largest peak;
  long compared = 0;
  for (std::size_t n = 0; n + 1 < run_tool.size(); ++n) {
    // If the drive jumps, velocities change before the step's forces are evaluated.
    if (run_tool[n].velocity != run_tool[n + 1].velocity) { continue; }
    const auto at = static_cast<Eigen::Index>(n);
    problem.force(run.time[n], run.time[n], run.position.col(at), run.velocity.col(at), force);
    double rate = 0.0;
    double pushed = 0.0;  // by springs on fixed nodes
    for (Eigen::Index i = 2; i < problem.dof(); i += 3) {
      rate += problem.mass()(i) * (run.velocity(i, at + 1) - run.velocity(i, at)) / h;
      pushed += force(i);
    }
    const double tool = run_tool[n].forces.total;
    const double impact = (run_tool[n + 1].losses.impulse - run_tool[n].losses.impulse) / h;
    worst.add(std::abs(rate - pushed - tool - impact));
    peak.add(std::abs(tool));
    ++compared;
  }
  outcome.judge_at_most("largest_imbalance_over_peak_force",
                        compared > 0 ? worst.value() / peak.value() : std::nan(""), 1e-9,
                        "Newton's third law: momentum of the tissue changes by the force on the "
                        "needle, that of the supports and the impulses of impacts");
}

void measure_energy(const CaseContext& context, Outcome& outcome) {
  Scene scene = seven_soft_layers();
  const double h = 5e-6;
  scene.drive->depth = 0.021;
  scene.drive->hold = 0.1;
  scene.drive->withdraw_speed = 0.04;
  scene.simulation = {
      .duration = context.quick ? 0.4 : 1.9, .step = h, .substeps = 1, .integrator = "rk4"};
  scene.output.audit = true;
  const auto [run, tool] = insert(context, scene, {.energy = true});
  const std::vector<double>& energy = run.values("energy_j");
  Largest worst;
  Series hand{.label = "work of the hand"};
  Series lost{.label = "lost"};
  Series stored{.label = "stored and moving"};
  for (std::size_t n = 1; n < tool.size(); ++n) {
    const ToolLosses& l = tool[n].losses;
    const double work = l.hand + l.jerk;
    const double gone = l.damping + l.cutting + l.friction + l.impact;
    worst.add(std::abs(work - (energy[n] - energy[0]) - gone));
    if (n % 2000 == 0) {
      hand.add(run.time[n], 1e3 * work);
      stored.add(run.time[n], 1e3 * energy[n]);
      lost.add(run.time[n], 1e3 * gone);
    }
  }
  const ToolLosses& l = tool.back().losses;
  outcome.judge_at_most(
      "largest_imbalance_over_work_of_the_hand", worst.value() / (l.hand + l.jerk), 1e-6,
      "law: balance of the work of the hand with energy and losses; trapezoids of 5 us");
  outcome.judge_at_least("work_of_the_hand", 1e3 * (l.hand + l.jerk), 0.5, "something was cut",
                         "mJ");
  outcome.tables.push_back(make_table("energy", "Where the work of the hand went", "",
                                      {"to", "energy (mJ)"},
                                      {{std::string("cutting"), 1e3 * l.cutting},
                                       {std::string("friction"), 1e3 * l.friction},
                                       {std::string("dampers"), 1e3 * l.damping},
                                       {std::string("impacts"), 1e3 * l.impact},
                                       {std::string("stored and moving"), 1e3 * energy.back()}}));
  outcome.figures.push_back(
      plot("energy", "Energy of an insertion",
           "What the hand gives is stored in springs or lost; the sum balances.", {"time (s)"},
           {"energy (mJ)"}, {hand, lost, stored}));
}

/// At rest what the supports carry is what the tool pushes.
void measure_supports_at_rest(const CaseContext& context, Outcome& outcome) {
  for (const bool probe : {false, true}) {
    Scene scene = seven_soft_layers();
    scene.drive->depth = 0.001;
    if (probe) {
      scene.needle.reset();
      scene.probe = Probe{.size = {0.004, 0.004}};  // presses free nodes alone
    }
    scene.simulation = {.duration = 1.5, .step = 1e-3, .integrator = "implicit-euler"};
    const auto [run, tool] =
        insert(context, scene, {.every = 1500, .position = true, .velocity = true, .energy = true});
    const NetworkProblem problem(build_network(scene));
    Eigen::VectorXd force(problem.dof());
    const Eigen::VectorXd still = Eigen::VectorXd::Zero(problem.dof());
    problem.force(0.0, 0.0, run.position.rightCols(1), still, force);
    double carried = 0.0;
    for (Eigen::Index i = 2; i < problem.dof(); i += 3) { carried -= force(i); }
    const double pushed = tool.back().forces.total;
    outcome.judge_at_most(probe ? "probe_imbalance_at_rest" : "needle_imbalance_at_rest",
                          std::abs(carried / pushed - 1.0), 1e-9,
                          "the force that is spread over the nodes sums to the tool's");
  }
}

// The shaft alone: a tip that nothing resists, tissue that rubs.

constexpr double friction = 20.0;  // [N/m]

Scene rubbing_scene() {
  Scene scene = chain_scene({.stiffness = 2000.0});
  scene.materials = {tissue_of("rubbing", 1.0, 0.0, friction)};
  scene.tissue.layers = {{"rubbing", "rubbing", 0.05}};
  return scene;
}

void measure_loop(const CaseContext& context, Outcome& outcome) {
  Scene scene = rubbing_scene();
  const double depth = 0.012;
  scene.drive =
      Drive{.from = -0.001, .speed = 0.02, .depth = depth, .hold = 0.1, .withdraw_speed = 0.02};
  const double h = 1e-5;
  scene.simulation = {.duration = 1.5, .step = h, .substeps = 1, .integrator = "velocity-verlet"};
  const auto [run, tool] = insert(context, scene);
  double area = 0.0;
  Largest largest;
  Smallest smallest(0.0);
  double slid = 0.0;
  Series force{.label = "force on the needle"};
  for (std::size_t n = 0; n < tool.size(); ++n) {
    const ToolReport& now = tool[n];
    largest.add(now.forces.friction);
    smallest.add(now.forces.friction);
    if (n > 0) {
      const ToolReport& last = tool[n - 1];
      area += 0.5 * h * (last.forces.friction * last.slip + now.forces.friction * now.slip);
      slid += 0.5 * (last.forces.total + now.forces.total) * (now.place - last.place);
    }
    if (n % 100 == 0) { force.add(1e3 * now.place, now.forces.total); }
  }
  const double lost = tool.back().losses.friction;
  outcome.judge_at_most(
      "area_of_friction_over_slip_less_dissipation", std::abs(area / lost - 1.0), 2e-5,
      "theory: friction times slip is what is lost; trapezoids over 10 us across two reversals");
  outcome.judge_between(
      "area_of_the_loop_over_dissipation", slid / lost, 0.98, 1.02,
      "theory: a closed loop stores nothing; dampers and impacts take less than 2 %");
  outcome.judge_at_most("largest_friction_over_limit", largest.value() / (friction * depth),
                        1.0 + 1e-12, "Coulomb: f times the length in tissue");
  outcome.judge_at_most(
      "asymmetry_of_the_loop", std::abs(largest.value() + smallest.value()) / largest.value(), 0.05,
      "theory: the same limit both ways; tissue length differs by its own strain, F/k of a spring");
  outcome.figures.push_back(plot("loop", "Friction of a shaft in and out",
                                 "In, rest, out: the loop's area is the energy that friction took.",
                                 {"place of the tip (mm)"}, {"force (N)"}, {force}));
}

void measure_stuck_shaft(const CaseContext& context, Outcome& outcome) {
  Scene scene = rubbing_scene();
  // Friction ends the push at 6 mm; the pull that follows is less than it can hold.
  const double pull = 0.05;
  scene.drive = Drive{.kind = Drive::Kind::force,
                      .hold = 4.0,
                      .force = 0.006 * friction,
                      .rise = 0.1,
                      .withdraw_force = pull,
                      .hand_viscosity = 5.0};
  const long ticks = context.quick ? 100000 : 1000000;
  scene.simulation = {
      .duration = 1e-3 * static_cast<double>(ticks), .step = 1e-3, .integrator = "velocity-verlet"};
  const auto [run, tool] = insert(context, scene, {.every = ticks / 20, .energy = true});
  const double settled = tool[2].place;
  Largest creep;
  for (std::size_t n = 3; n < tool.size(); ++n) { creep.add(std::abs(tool[n].place - settled)); }
  outcome.judge_at_most("creep", run.diverged ? std::nan("") : creep.value(),
                        static_cast<double>(ticks) * 2.3e-16 * 0.02,
                        "law: a stuck shaft does not move; one rounding of a place of 20 mm a tick",
                        "m");
  outcome.judge_near("friction_at_rest", tool.back().forces.friction, -pull, 1e-9,
                     "balance: it carries the whole force of the hand", "N");
  outcome.judge_at_most("slip_at_rest", std::abs(tool.back().slip), 1e-15,
                        "law: what sticks has no slip; rounding", "m/s");
}

}  // namespace

std::vector<Case> balance_cases() {
  return {{"needle/parts", "accuracy",
           "Cutting, friction and stiffness add up to the force at every tick (Eq. 2), and no part "
           "exceeds its law.",
           measure_parts, 1.0},
          {"needle/momentum", "accuracy",
           "What the needle feels is what the tissue and its supports gain in momentum.",
           measure_momentum, 2.0},
          {"needle/rest", "accuracy", "At rest the supports carry what needle or probe push.",
           measure_supports_at_rest, 1.0},
          {"needle/energy", "accuracy",
           "The work of the hand is stored, moves, or is lost in dampers, cutting, friction and "
           "impacts.",
           measure_energy, 8.0},
          {"needle/friction/loop", "accuracy",
           "In and out, the force of the shaft draws a loop whose area is the energy lost.",
           measure_loop, 1.0},
          {"needle/friction/rest", "accuracy",
           "Under less than its limit a shaft sticks and does not creep, however long.",
           measure_stuck_shaft, 6.0}};
}

}  // namespace palpate::tools
