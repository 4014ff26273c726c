// SPDX-License-Identifier: MIT
/// Observed order of every scheme on a lattice that is pushed far enough to be nonlinear, with and
/// without damping, against a reference of ten digits.

#include <algorithm>
#include <cmath>

#include "model/stepping/integrator.hpp"
#include "reference/arkode.hpp"
#include "reference/ensemble.hpp"
#include "reference/linear_problem.hpp"
#include "validation/cases/network_parts.hpp"
#include "validation/cases/network_support.hpp"

namespace palpate::networks {

namespace {

constexpr long ticks = 16;
constexpr double tick = 1.25e-3;  ///< [s]

SpringNetwork lattice(bool damped) {
  const Block block{.nodes = {4, 4, 4}, .relaxation = damped ? 5e-4 : 0.0};
  SpringNetwork network = block_network(block);
  hold(network, Face::z_max);
  // Forces at t = 0: from rest, a velocity that is half a step late would cost nothing.
  displace(network, 0.03 * block.spacing, 17);
  return network;
}

/// A smooth push that begins and ends with a tick.
Scene pushed(const std::string& scheme, int substeps) {
  Scene scene = scene_of(scheme, tick, static_cast<double>(ticks) * tick, substeps);
  scene.loads = {{.face = Face::z_min,
                  .force = {4e-3, 2e-3, 4e-3},
                  .start = tick,
                  .end = 11 * tick,
                  .profile = Profile::half_sine}};
  return scene;
}

const TruthSettings settings{.tolerance = {.relative = 1e-13}, .demanded_digits = 10.0};

/// Substeps a tick: errors between 10 % and the reference's floor, steps below the stability limit.
std::vector<int> ladder(const IntegratorInfo& scheme, int order, bool quick) {
  int substeps = order == 1 ? 64 : order == 2 ? 16 : 4;
  if (scheme.name == "euler") { substeps = 256; }  // gains energy at first order in the step
  if (scheme.implicit) { substeps = order == 1 ? (quick ? 8 : 16) : (quick ? 4 : 8); }
  std::vector<int> rungs;
  for (int rung = 0; rung < 5; ++rung) { rungs.push_back(substeps << rung); }
  return rungs;
}

/// Share of the motion that a linearised lattice would not show.
double nonlinear_share(const NetworkProblem& problem, const Truth& truth) {
  const reference::LinearProblem linear(problem);
  const reference::Solution straight =
      reference::solve_arkode_explicit(linear, truth.solution.time, {.relative = 1e-8});
  return trajectory_error(straight.position, truth.solution.position,
                          truth.solution.position.col(0))
      .maximum;
}

struct Ladder {
  std::vector<double> steps{};   ///< [s]
  std::vector<double> errors{};  ///< largest, over the peak
};

Ladder climb(const CaseContext& context, const IntegratorInfo& scheme, int order,
             const SpringNetwork& network, const Truth& truth) {
  Ladder climbed;
  for (const int substeps : ladder(scheme, order, context.quick)) {
    const Motion motion = simulate(context, pushed(std::string(scheme.name), substeps), &network);
    climbed.steps.push_back(tick / substeps);
    climbed.errors.push_back(motion.diverged ? std::nan("")
                                             : distance(motion, truth.solution).maximum);
  }
  return climbed;
}

void draw(const Ladder& climbed, int order, const std::string& how, double floor, Figure& figure) {
  const auto& [steps, errors] = climbed;
  const std::vector<double> ends{steps.front(), steps.back()};
  const double slope = errors.back() * std::pow(ends[0] / ends[1], order);
  figure.series.push_back(line(how, steps, errors, Series::Style::line_and_points));
  figure.series.push_back(
      line("order " + std::to_string(order), ends, {slope, errors.back()}, Series::Style::dashed));
  figure.series.push_back(line("reference, " + how, ends, {floor, floor}, Series::Style::dashed));
}

void judge_order(const CaseContext& context, const IntegratorInfo& scheme, bool damped,
                 Figure& figure, Outcome& outcome) {
  const std::string how = damped ? "damped" : "undamped";
  const int expected = damped ? scheme.order_damped : scheme.order_undamped;
  const SpringNetwork network = lattice(damped);
  const NetworkProblem problem = problem_of(pushed("rk4", 1), network);
  const Truth truth = find_truth(context, problem, instants(tick, ticks), settings);
  const Ladder climbed = climb(context, scheme, expected, network, truth);
  const double floor = std::max(100.0 * truth.worst_floor, 1e-12);
  const ObservedOrder order = observed_order(climbed.steps, climbed.errors, floor);
  const auto judge = [&](const std::string& what, double value, double lower, double upper,
                         const std::string& why) {
    outcome.judge({.name = what + "_" + how,
                   .value = value,
                   .lower = lower,
                   .upper = upper,
                   .bound_from = why});
  };
  judge("observed_order", order.slope, expected - 0.15, expected + 0.15, "theory");
  judge("errors_fall", order.monotone ? 1.0 : 0.0, 1.0, unbounded, "a smaller step must be closer");
  judge("reference_agreed_digits", truth.trustworthy ? truth.agreed_digits : 0.0,
        settings.demanded_digits, unbounded, "two families of solvers must agree to ten digits");
  judge("nonlinear_share", nonlinear_share(problem, truth), 0.01, unbounded,
        "less would judge a linear lattice");
  outcome.quantities.push_back({.name = "rungs_" + how, .value = static_cast<double>(order.rungs)});
  outcome.quantities.push_back({.name = "r_squared_" + how, .value = order.r_squared});
  draw(climbed, expected, how, truth.worst_floor, figure);
}

void measure(const CaseContext& context, const IntegratorInfo& scheme, Outcome& outcome) {
  Figure figure{.id = "order",
                .title = "Error of " + std::string(scheme.name) + " on a nonlinear lattice",
                .caption =
                    "Largest error over the peak displacement, beside slopes of the expected "
                    "order and the floor of the reference.",
                .x = {.label = "step (s)", .logarithmic = true},
                .y = {.label = "largest error / peak", .logarithmic = true}};
  for (const bool damped : {false, true}) { judge_order(context, scheme, damped, figure, outcome); }
  outcome.figures.push_back(std::move(figure));
}

Figure ladder_figure(const reference::Reference& found) {
  Figure figure{.id = "ladder",
                .title = "Ladder of tolerances of the reference",
                .caption =
                    "Distance of looser runs from the finest; the dashed line is where the "
                    "families stop agreeing.",
                .x = {.label = "relative tolerance", .logarithmic = true},
                .y = {.label = "largest difference / peak", .logarithmic = true}};
  Series rungs{.label = settings.solvers[0], .style = Series::Style::line_and_points};
  for (const reference::Rung& rung : found.ladder) {
    rungs.x.push_back(rung.relative_tolerance);
    rungs.y.push_back(rung.position_error);
  }
  const double floor = std::pow(10.0, -found.agreed_digits);
  figure.series.push_back(
      line("agreement", {rungs.x.back(), rungs.x.front()}, {floor, floor}, Series::Style::dashed));
  figure.series.push_back(std::move(rungs));
  return figure;
}

/// The reference of the cases above, under every check that a reference can be put to.
void measure_reference(const CaseContext& context, Outcome& outcome) {
  const NetworkProblem problem = problem_of(pushed("rk4", 1), lattice(true));
  using reference::solver_named;
  std::vector<reference::NamedSolver> families{solver_named(settings.solvers[0]),
                                               solver_named(settings.solvers[1]),
                                               solver_named("gsl-rk8pd")};
  if (!context.quick) { families.push_back(solver_named("long-double-fehlberg-7-8")); }
  const reference::Reference found =
      reference::establish(problem, instants(tick, ticks), settings.tolerance, families,
                           {.rungs = 5,
                            .demanded_digits = settings.demanded_digits,
                            .cache = context.cache,
                            .permute_springs = true});
  const auto judge = [&](const char* name, double value, double lower, const char* why) {
    outcome.judge({.name = name, .value = value, .lower = lower, .bound_from = why});
  };
  judge("agreed_digits", found.agreed_digits, settings.demanded_digits,
        "demanded by the order cases: two digits below their finest rung");
  judge("agreed_velocity_digits", found.agreed_velocity_digits, settings.demanded_digits - 1.0,
        "one digit less than positions");
  judge("ladder_is_monotone", found.ladder_is_monotone ? 1.0 : 0.0, 1.0,
        "tighter tolerances must come closer");
  judge("conditioning_digits", found.conditioning_digits.value_or(0.0), settings.demanded_digits,
        "springs in another order may cost no digit asked for");
  judge("trustworthy", found.trustworthy ? 1.0 : 0.0, 1.0, "every check of the reference");
  if (!found.reason.empty()) { outcome.notes.push_back(found.reason); }
  for (const std::string& note : found.notes) { outcome.notes.push_back(note); }
  outcome.figures.push_back(ladder_figure(found));
}

}  // namespace

std::vector<Case> order_cases() {
  std::vector<Case> cases{
      {.name = "network/reference",
       .suite = "accuracy",
       .claim = "Independent solvers agree on a nonlinear lattice to ten digits, and tighter "
                "tolerances come closer.",
       .measure = measure_reference,
       .weight = 1.0}};
  for (const IntegratorInfo* scheme : integrators()) {
    cases.push_back({.name = "network/order/" + std::string(scheme->name),
                     .suite = "accuracy",
                     .claim = "On a nonlinear lattice " + std::string(scheme->name) +
                              " has order " + std::to_string(scheme->order_undamped) +
                              " without and order " + std::to_string(scheme->order_damped) +
                              " with damping.",
                     .measure = [scheme](const CaseContext& context,
                                         Outcome& outcome) { measure(context, *scheme, outcome); },
                     .weight = scheme->implicit ? 3.0 : 1.0});
  }
  return cases;
}

}  // namespace palpate::networks
