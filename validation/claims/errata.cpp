// SPDX-License-Identifier: MIT
/// The errata that change how stiff the tissue is, judged by static deflection and by decay.

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "model/tissue/network_builder.hpp"
#include "reference/static_equilibrium.hpp"
#include "validation/claims/errata_fixture.hpp"
#include "validation/claims/groups.hpp"

namespace palpate::errata {

namespace {

constexpr double touch = 1e-7;  ///< [N] deflects by 1e-9 m, and tissue 150 times softer by 1e-7 m

/// Returns the equilibrium from implicit Euler with steps of 10 s, which damp every mode of the
/// lattice.
Eigen::VectorXd rest_under(const CaseContext& context, const PrintedForm& printed, double force) {
  Scene scene = lattice_scene(10.0, 300.0, "implicit-euler");
  scene.simulation.printed = printed;
  scene.loads.push_back({.nodes = {pressed_node}, .force = {0.0, 0.0, force}});
  const SpringNetwork network = build_network(scene);
  const Trace motion = roll_out(context, scene, &network, {.every = 30, .position = true});
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

/// Returns the displacement of the pressed node [m] from the linearised printed equations.
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

/// Judges the stiffness at a point and returns printed over corrected.
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

/// Measures the decay of the slowest mode.
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

// Errata that make a lattice diverge, compared with the growth rate of the linearised printed
// equations.

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

/// Duration after which every growing mode exceeds all bounds.
Trace run_away(const CaseContext& context, const PrintedForm& printed, double seconds) {
  const Scene scene = pressed_scene(step, seconds, printed);
  const SpringNetwork network = build_network(scene);
  return roll_out(context, scene, &network, {.every = 100, .position = true});
}

void judge_runaway(const CaseContext& context, Outcome& outcome, const PrintedForm& printed,
                   const std::string& name, double seconds) {
  const Trace motion = run_away(context, printed, seconds);
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
  const Trace ticks = roll_out(context, soft, &network, {.position = true});
  const Trace slow = roll_out(context, seconds, &network, {.position = true});
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

namespace palpate {

namespace {

using namespace errata;

struct Erratum {
  std::string name;
  std::string claim;
  Finding (*measure)(const CaseContext& context, Outcome& outcome);
};

const std::array<Erratum, 7>& all_errata() {
  static const std::array<Erratum, 7> all{
      Erratum{"sign",
              "With the printed sign a lattice diverges at the rate that its equations say.",
              measure_sign},
      Erratum{"reversed",
              "With the printed force turned round the dampers make a lattice diverge at the rate "
              "that its equations say.",
              measure_reversed},
      Erratum{"direction", "Multiplying by d instead of u makes stiffness scale with length.",
              measure_direction},
      Erratum{"half-force", "Halving each force halves stiffness and damping, exactly.",
              measure_half_force},
      Erratum{"no-time-step", "Without the time step every tick is a step of one second.",
              measure_no_time_step},
      Erratum{"lagged-velocity",
              "The printed spring velocity costs one order of accuracy and some stability.",
              measure_lagged_velocity},
      Erratum{"all-printed", "The equations as printed diverge within a few ticks.",
              measure_all_printed}};
  return all;
}

void measure_summary(const CaseContext& context, Outcome& outcome) {
  Table table{
      .id = "errata",
      .title = "What each printed form does",
      .caption =
          "Each erratum alone and all together, measured on the model and predicted "
          "from the printed equations.",
      .columns = {"erratum", "printed in", "what it does", "quantity", "measured", "predicted"}};
  for (const Erratum& erratum : all_errata()) {
    Outcome own;
    const Finding finding = erratum.measure(context, own);
    conclude(own);
    outcome.judge({.name = erratum.name + ": claims that do not hold",
                   .value = static_cast<double>(std::ranges::count_if(
                       own.quantities, [](const Quantity& q) { return q.judged() && !q.holds(); })),
                   .upper = 0.0,
                   .bound_from = "errata/" + erratum.name});
    outcome.judge({.name = erratum.name + ": measured over predicted",
                   .value = finding.measured / finding.predicted});
    table.rows.push_back({finding.erratum, finding.printed, finding.effect, finding.quantity,
                          finding.measured, finding.predicted});
  }
  outcome.tables.push_back(std::move(table));
}

}  // namespace

std::vector<Case> errata_cases() {
  std::vector<Case> cases;
  for (const Erratum& erratum : all_errata()) {
    cases.push_back({.name = "errata/" + erratum.name,
                     .suite = "model",
                     .claim = erratum.claim,
                     .measure = [&erratum](const CaseContext& context,
                                           Outcome& outcome) { erratum.measure(context, outcome); },
                     .weight = 0.5});
  }
  cases.push_back({.name = "errata/summary",
                   .suite = "model",
                   .claim = "Each printed form does what its equations predict.",
                   .measure = measure_summary,
                   .weight = 3.0});
  return cases;
}

}  // namespace palpate
