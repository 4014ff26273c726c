// SPDX-License-Identifier: MIT
/// Balances at every tick of an insertion: parts of the force, momentum, energy.

#include <cmath>

#include "model/tissue/network_builder.hpp"
#include "validation/claims/tool_fixture.hpp"

namespace palpate::tools {

namespace {

double worse(double worst, double value) {
  return std::isnan(value) || std::isnan(worst) ? std::nan("") : std::max(worst, std::abs(value));
}

void measure_parts(const CaseContext& context, Outcome& outcome) {
  Scene scene = seven_soft_layers();
  scene.simulation = {.duration = 1.15, .step = 1e-3, .integrator = "velocity-verlet"};
  const Trace run = roll_out(context, scene, {.tool = true});
  const std::vector<ToolReport> tool = tool_rows(run);
  double sum = 0.0;
  double applied = 0.0;
  double above = 0.0;
  double peak = 0.0;
  for (std::size_t n = 0; n < tool.size(); ++n) {
    const ToolForces& f = tool[n].forces;
    sum = worse(sum, f.total - (f.cutting + f.friction + f.stiffness));
    applied = worse(applied, f.applied - f.total);
    above = worse(above, std::max(0.0, std::max(f.cutting, f.stiffness) - 1.2));
    peak = worse(peak, f.total);
  }
  const std::string rounding = "Eq. 2: nothing but rounding";
  outcome.judge({.name = "largest_difference_of_parts_and_total",
                 .value = sum,
                 .unit = "N",
                 .upper = 4e-16 * 4.0,
                 .bound_from = rounding});
  outcome.judge({.name = "largest_difference_of_applied_and_total",
                 .value = applied,
                 .unit = "N",
                 .upper = 0.0,
                 .bound_from = "a prescribed drive applies what resists it"});
  outcome.judge({.name = "tip_force_above_the_strongest_cutting_force",
                 .value = above,
                 .unit = "N",
                 .upper = 0.0,
                 .bound_from = "law: the tip cuts before it pushes harder"});
  outcome.judge({.name = "samples",
                 .value = static_cast<double>(tool.size()),
                 .lower = 1151.0,
                 .upper = 1151.0,
                 .bound_from = "one a tick and the beginning"});
  outcome.judge({.name = "peak_force",
                 .value = peak,
                 .unit = "N",
                 .lower = 1.2,
                 .upper = 1.2 + 0.5,
                 .bound_from = "cutting force of the flavum and the friction of the whole track"});
}

/// Euler-Cromer moves momentum by exactly h times the forces at the beginning of a step.
void measure_momentum(const CaseContext& context, Outcome& outcome) {
  Scene scene = seven_soft_layers();
  const double h = 1e-5;
  scene.simulation = {.duration = 0.4, .step = h, .substeps = 1, .integrator = "euler-cromer"};
  const Trace run =
      roll_out(context, scene, {.position = true, .velocity = true, .energy = true, .tool = true});
  const std::vector<ToolReport> run_tool = tool_rows(run);
  const NetworkProblem problem(build_network(scene));
  Eigen::VectorXd force(problem.dof());
  double worst = 0.0;
  double peak = 0.0;
  long compared = 0;
  for (std::size_t n = 0; n + 1 < run_tool.size(); ++n) {
    // Where the drive jumps, velocities change before the step's forces are evaluated.
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
    worst = worse(worst, rate - pushed - tool - impact);
    peak = worse(peak, tool);
    ++compared;
  }
  outcome.judge({.name = "largest_imbalance_over_peak_force",
                 .value = compared > 0 ? worst / peak : std::nan(""),
                 .upper = 1e-9,
                 .bound_from = "Newton's third law: momentum of the tissue changes by the force on "
                               "the needle, that of the supports and the impulses of impacts"});
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
  const Trace run = roll_out(context, scene, {.every = 1, .energy = true, .tool = true});
  const std::vector<ToolReport> tool = tool_rows(run);
  double worst = 0.0;
  std::vector<double> time, hand, stored, lost;
  for (std::size_t n = 1; n < tool.size(); ++n) {
    const ToolLosses& l = tool[n].losses;
    const double work = l.hand + l.jerk;
    const double gone = l.damping + l.cutting + l.friction + l.impact;
    worst = worse(worst, work - (run.values("energy_j")[n] - run.values("energy_j")[0]) - gone);
    if (n % 2000 == 0) {
      time.push_back(run.time[n]);
      hand.push_back(1e3 * work);
      stored.push_back(1e3 * run.values("energy_j")[n]);
      lost.push_back(1e3 * gone);
    }
  }
  const ToolLosses& l = tool.back().losses;
  outcome.judge({.name = "largest_imbalance_over_work_of_the_hand",
                 .value = worst / (l.hand + l.jerk),
                 .upper = 1e-6,
                 .bound_from = "law: work of the hand = stored + moving + dampers + cutting + "
                               "friction + impacts; trapezoids of 5 us"});
  outcome.judge({.name = "work_of_the_hand",
                 .value = 1e3 * (l.hand + l.jerk),
                 .unit = "mJ",
                 .lower = 0.5,
                 .bound_from = "something was cut"});
  outcome.tables.push_back(
      {.id = "energy",
       .title = "Where the work of the hand went",
       .columns = {"to", "energy (mJ)"},
       .rows = {{std::string("cutting"), 1e3 * l.cutting},
                {std::string("friction"), 1e3 * l.friction},
                {std::string("dampers"), 1e3 * l.damping},
                {std::string("impacts"), 1e3 * l.impact},
                {std::string("stored and moving"), 1e3 * run.values("energy_j").back()}}});
  Figure figure{.id = "energy",
                .title = "Energy of an insertion",
                .caption = "What the hand gives is stored in springs or lost; the sum balances.",
                .x = {.label = "time (s)"},
                .y = {.label = "energy (mJ)"}};
  figure.series = {curve("work of the hand", time, hand), curve("lost", time, lost),
                   curve("stored and moving", time, stored)};
  outcome.figures.push_back(std::move(figure));
}

/// At rest what the supports carry is what the tool pushes.
void measure_supports_at_rest(const CaseContext& context, Outcome& outcome) {
  for (const bool probe : {false, true}) {
    Scene scene = seven_soft_layers();
    scene.drive->depth = 0.001;
    if (probe) {
      scene.needle.reset();
      scene.probe = Probe{.size = {0.006, 0.006}};
    }
    scene.simulation = {.duration = 1.5, .step = 1e-3, .integrator = "implicit-euler"};
    const Trace run =
        roll_out(context, scene,
                 {.every = 1500, .position = true, .velocity = true, .energy = true, .tool = true});
    const std::vector<ToolReport> tool = tool_rows(run);
    const NetworkProblem problem(build_network(scene));
    Eigen::VectorXd force(problem.dof());
    const Eigen::VectorXd still = Eigen::VectorXd::Zero(problem.dof());
    problem.force(0.0, 0.0, run.position.rightCols(1), still, force);
    double carried = 0.0;
    for (Eigen::Index i = 2; i < problem.dof(); i += 3) { carried -= force(i); }
    const double pushed = tool.back().forces.total;
    outcome.judge({.name = probe ? "probe_imbalance_at_rest" : "needle_imbalance_at_rest",
                   .value = std::abs(carried / pushed - 1.0),
                   .upper = 1e-9,
                   .bound_from = "the force that is spread over the nodes sums to the tool's"});
  }
}

}  // namespace

std::vector<Case> balance_cases() {
  return {
      {.name = "needle/parts",
       .suite = "accuracy",
       .claim = "Cutting, friction and stiffness add up to the force at every tick (Eq. 2), and "
                "no part exceeds its law.",
       .measure = measure_parts,
       .weight = 1.0},
      {.name = "needle/momentum",
       .suite = "accuracy",
       .claim = "What the needle feels is what the tissue and its supports gain in momentum.",
       .measure = measure_momentum,
       .weight = 2.0},
      {.name = "needle/rest",
       .suite = "accuracy",
       .claim = "At rest the supports carry what needle or probe push.",
       .measure = measure_supports_at_rest,
       .weight = 1.0},
      {.name = "needle/energy",
       .suite = "accuracy",
       .claim = "The work of the hand is stored, moves, or is lost in dampers, cutting, "
                "friction and impacts.",
       .measure = measure_energy,
       .weight = 8.0}};
}

// The shaft alone: a tip that nothing resists, tissue that rubs.

namespace {

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
  const Trace run = roll_out(context, scene, {.tool = true});
  const std::vector<ToolReport> tool = tool_rows(run);
  double area = 0.0;
  double largest = 0.0;
  double smallest = 0.0;
  double slid = 0.0;
  std::vector<double> place, force;
  for (std::size_t n = 0; n < tool.size(); ++n) {
    const ToolReport& now = tool[n];
    largest = std::fmax(largest, now.forces.friction);
    smallest = std::fmin(smallest, now.forces.friction);
    if (n > 0) {
      const ToolReport& last = tool[n - 1];
      area += 0.5 * h * (last.forces.friction * last.slip + now.forces.friction * now.slip);
      slid += 0.5 * (last.forces.total + now.forces.total) * (now.place - last.place);
    }
    if (n % 100 == 0) {
      place.push_back(1e3 * now.place);
      force.push_back(now.forces.total);
    }
  }
  const double lost = tool.back().losses.friction;
  outcome.judge({.name = "area_of_friction_over_slip_less_dissipation",
                 .value = std::abs(area / lost - 1.0),
                 .upper = 1e-3,
                 .bound_from = "theory: friction times slip is what is lost; trapezoids over 10 us "
                               "across two reversals"});
  outcome.judge({.name = "area_of_the_loop_over_dissipation",
                 .value = slid / lost,
                 .lower = 0.98,
                 .upper = 1.02,
                 .bound_from = "theory: a closed loop stores nothing; dampers and impacts take "
                               "less than 2 %"});
  outcome.judge({.name = "largest_friction_over_limit",
                 .value = largest / (friction * depth),
                 .upper = 1.0 + 1e-12,
                 .bound_from = "Coulomb: f times the length in tissue"});
  outcome.judge({.name = "asymmetry_of_the_loop",
                 .value = std::abs(largest + smallest) / largest,
                 .upper = 0.05,
                 .bound_from = "theory: the same limit both ways; tissue length differs by its "
                               "own strain, F/k of a spring"});
  Figure figure{.id = "loop",
                .title = "Friction of a shaft in and out",
                .caption = "In, rest, out: the loop's area is the energy that friction took.",
                .x = {.label = "place of the tip (mm)"},
                .y = {.label = "force (N)"}};
  figure.series = {curve("force on the needle", place, force)};
  outcome.figures.push_back(std::move(figure));
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
  const Trace run = roll_out(context, scene, {.every = ticks / 20, .energy = true, .tool = true});
  const std::vector<ToolReport> tool = tool_rows(run);
  const double settled = tool[2].place;
  double creep = 0.0;
  for (std::size_t n = 3; n < tool.size(); ++n) {
    creep = std::fmax(creep, std::abs(tool[n].place - settled));
  }
  outcome.judge({.name = "creep",
                 .value = run.diverged ? std::nan("") : creep,
                 .unit = "m",
                 .upper = static_cast<double>(ticks) * 2.3e-16 * 0.02,
                 .bound_from = "law: a stuck shaft does not move; one rounding of a place of 20 mm "
                               "a tick"});
  outcome.judge({.name = "friction_at_rest",
                 .value = tool.back().forces.friction,
                 .unit = "N",
                 .lower = -pull - 1e-9,
                 .upper = -pull + 1e-9,
                 .bound_from = "balance: it carries the whole force of the hand"});
  outcome.judge({.name = "slip_at_rest",
                 .value = std::abs(tool.back().slip),
                 .unit = "m/s",
                 .upper = 1e-15,
                 .bound_from = "law: what sticks has no slip; rounding"});
}

}  // namespace

std::vector<Case> friction_cases() {
  return {
      {.name = "needle/friction/loop",
       .suite = "accuracy",
       .claim = "In and out, the force of the shaft draws a loop whose area is the energy lost.",
       .measure = measure_loop,
       .weight = 1.0},
      {.name = "needle/friction/rest",
       .suite = "accuracy",
       .claim = "Under less than its limit a shaft sticks and does not creep, however long.",
       .measure = measure_stuck_shaft,
       .weight = 6.0}};
}

}  // namespace palpate::tools
