// SPDX-License-Identifier: MIT
/// The errata that change how stiff the tissue is, judged by static deflection and by decay.

#include <cmath>

#include <Eigen/Cholesky>

#include "model/dynamics/network_builder.hpp"
#include "reference/static_equilibrium.hpp"
#include "validation/cases/errata_parts.hpp"
#include "validation/cases/errata_pressed.hpp"

namespace palpate::errata {

namespace {

constexpr double touch = 1e-7;  ///< [N] deflects by 1e-9 m, and tissue 150 times softer by 1e-7 m

/// Where implicit Euler comes to rest with steps of 10 s, which no mode of the lattice outlives.
Eigen::VectorXd rest_under(const CaseContext& context, const PrintedForm& printed, double force) {
  Scene scene = lattice_scene(10.0, 300.0, "implicit-euler");
  scene.simulation.printed = printed;
  scene.loads.push_back({.nodes = {pressed_node}, .force = {0.0, 0.0, force}});
  const SpringNetwork network = build_network(scene);
  const Motion motion = simulate(context, scene, &network, {.every = 30});
  if (motion.diverged || motion.position.cols() < 2 ||
      motion.position.rows() != 3 * (network.node_count() - 9)) {
    return Eigen::VectorXd::Constant(1, std::nan(""));
  }
  return motion.position.rightCols(1) - motion.position.col(0);
}

double depth(const Eigen::VectorXd& displacement) {
  const Eigen::Index at = 3 * pressed_node + 2;
  return displacement.size() > at ? displacement(at) : std::nan("");
}

/// [m] of the pressed node by the linearised printed equations.
double predicted_depth(const PrintedForm& printed, double force) {
  const SpringNetwork network = build_network(lattice_scene(step, step));
  const Linear linear = linearise(network, printed);
  Eigen::VectorXd f = Eigen::VectorXd::Zero(linear.stiffness.rows());
  f(3 * pressed_node + 2) = force / network.mass(pressed_node);
  return depth(linear.stiffness.ldlt().solve(f));  // one mass for all: still symmetric
}

double reference_depth(const PrintedForm& printed, double force) {
  Scene scene = lattice_scene(step, step);
  scene.loads.push_back({.nodes = {pressed_node}, .force = {0.0, 0.0, force}});
  const SpringNetwork network = build_network(scene);
  const NetworkProblem problem(network, resolve_loads(scene, network), Eigen::Vector3d::Zero(),
                               printed);
  return depth(reference::static_equilibrium(problem).position - problem.initial_position());
}

void judge_ratio(Outcome& outcome, const std::string& name, double value, double expected,
                 double tolerance, const std::string& from) {
  outcome.judge({.name = name,
                 .value = value,
                 .lower = expected * (1.0 - tolerance),
                 .upper = expected * (1.0 + tolerance),
                 .bound_from = from});
}

/// Stiffness felt by a finger, printed over corrected.
double judge_stiffness(const CaseContext& context, Outcome& outcome, const PrintedForm& printed,
                       double expected) {
  const double corrected = depth(rest_under(context, {}, touch));
  const double wrong = depth(rest_under(context, printed, touch));
  const std::string strain = "; strains below 1e-4 bend it";
  judge_ratio(outcome, "corrected depth over the linear one",
              corrected / predicted_depth({}, touch), 1.0, 1e-4, "K^-1 f" + strain);
  judge_ratio(outcome, "corrected depth over the Newton solution",
              corrected / reference_depth({}, touch), 1.0, 1e-8,
              "Newton to 1e-12; 1e-18 m of rounding in 1e-9 m");
  judge_ratio(outcome, "printed depth over the Newton solution of the printed equations",
              wrong / reference_depth(printed, touch), 1.0, 1e-8,
              "Newton to 1e-12; 1e-18 m of rounding in 1e-9 m");
  judge_ratio(outcome, "stiffness, printed over corrected", corrected / wrong, expected, 1e-4,
              "static deflection by the printed equations" + strain);
  return corrected / wrong;
}

/// Decay of the slowest mode.
void judge_decay(const CaseContext& context, Outcome& outcome, const PrintedForm& printed,
                 const std::string& name) {
  const Rate rate = measure_rate(context, printed, step, step);
  judge_ratio(outcome, name + ": decay of the slowest mode over its prediction",
              rate.measured / rate.predicted, 1.0, 1e-4,
              "eigenvalue of the linearised printed step; strains of 1e-4 bend it");
  outcome.judge(
      {.name = name + ": decay of the slowest mode", .value = -rate.measured, .unit = "1/s"});
}

/// The printed form is a well-posed model of other tissue: ARKODE on it must agree with it.
void judge_other_tissue(const CaseContext& context, Outcome& outcome, const PrintedForm& printed) {
  const long ticks = 500;
  const Eigen::MatrixXd truth = solve_pressed(pressed_times(), printed);
  const Pressed coarse = run_pressed(context, printed, ticks);
  const Pressed fine = run_pressed(context, printed, 2 * ticks);
  const double expected = 2.0 * distance(fine.displacement, coarse.displacement);
  outcome.judge(
      {.name = "printed form against ARKODE on the printed equations",
       .value = distance(coarse.displacement, truth),
       .lower = 0.85 * expected,
       .upper = 1.15 * expected,
       .bound_from = "twice the change on halving the step (order 1), +-15 % of order 2"});
}

}  // namespace

Finding measure_direction(const CaseContext& context, Outcome& outcome) {
  const PrintedForm printed{.direction = true};
  const double expected = predicted_depth({}, touch) / predicted_depth(printed, touch);
  const double found = judge_stiffness(context, outcome, printed, expected);
  outcome.judge({.name = "stiffness ratio over the shortest spring's length",
                 .value = found / 0.005,
                 .lower = 1.0,
                 .upper = std::sqrt(3.0),
                 .bound_from = "springs are from 1 to sqrt 3 spacings long"});
  judge_decay(context, outcome, {}, "corrected");
  judge_decay(context, outcome, printed, "direction");
  judge_other_tissue(context, outcome, printed);
  compare_pressed(context, outcome, printed, "direction");
  outcome.notes.emplace_back(
      "Multiplying by d makes a spring's stiffness k L in N: with lengths in metres this lattice "
      "is "
      "some 150 times too soft, with lengths in millimetres it would be too stiff, and diagonals "
      "gain on edges.");
  return {"direction",           "Eq. 12", "stiffness scales with each spring's length in metres",
          "stiffness ratio (1)", found,    expected};
}

Finding measure_half_force(const CaseContext& context, Outcome& outcome) {
  const PrintedForm printed{.half_force = true};
  const double found = judge_stiffness(context, outcome, printed, 0.5);
  // Exactly, not only for small strains: half of every force under the load is the whole of every
  // force under twice the load.
  const Eigen::VectorXd halved = rest_under(context, printed, press);
  const Eigen::VectorXd doubled = rest_under(context, {}, 2.0 * press);
  const double difference =
      halved.size() == doubled.size() ? (halved - doubled).norm() / doubled.norm() : std::nan("");
  outcome.judge(
      {.name = "half forces under a load less whole forces under twice the load",
       .value = difference,
       .upper = 1e-9,
       .bound_from = "equal equilibria; Newton to 64 eps, 1e-18 m of rounding in 1e-3 m"});
  judge_decay(context, outcome, {}, "corrected");
  judge_decay(context, outcome, printed, "half force");
  judge_other_tissue(context, outcome, printed);
  compare_pressed(context, outcome, printed, "half-force");
  return {"half force",          "Eq. 14", "half as stiff and half as damped",
          "stiffness ratio (1)", found,    0.5};
}

}  // namespace palpate::errata
