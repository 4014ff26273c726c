// SPDX-License-Identifier: MIT

#include <limits>

#include "reference/exact_problems.hpp"
#include "reference/solver_cross_check.hpp"
#include "reference/solvers.hpp"
#include "tests/check.hpp"
#include "tests/reference/sample_problems.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using namespace palpate::reference;
using Eigen::MatrixXd;

MatrixXd ramp() {  // two coordinates, three instants; moves by at most 4
  MatrixXd q(2, 3);
  q << 1.0, 2.0, 5.0, -1.0, -1.0, -2.0;
  return q;
}

TEST("the error is the worst coordinate at the worst instant over a scale from the first instant") {
  CHECK(peak_displacement(ramp()) == 4.0);
  CHECK(peak_speed(ramp()) == 5.0);
  MatrixXd candidate = ramp();
  candidate(1, 1) += 0.4;
  candidate(0, 2) -= 0.2;
  CHECK_NEAR(trajectory_error(candidate, ramp(), 4.0), 0.1, 1e-15);
  CHECK_NEAR(instant_errors(candidate, ramp(), 4.0)[2], 0.05, 1e-15);
  CHECK_THROWS(trajectory_error(MatrixXd::Zero(2, 2), ramp(), 1.0), "different size");
  CHECK_THROWS(trajectory_error(MatrixXd(), MatrixXd(), 1.0), "different size");
}

TEST("a NaN or an infinity anywhere makes the error infinite") {
  for (const double poison : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    for (Eigen::Index i = 0; i < 2; ++i) {
      MatrixXd candidate = ramp();
      candidate(i, 1) = poison;
      CHECK(std::isinf(trajectory_error(candidate, ramp(), 4.0)));
      CHECK(std::isinf(trajectory_error(ramp(), candidate, peak_displacement(candidate))));
      CHECK(digits(trajectory_error(candidate, ramp(), 4.0)) == 0.0);
    }
  }
}

TEST("where nothing moves equal is zero and different is infinite") {
  const MatrixXd still = MatrixXd::Ones(2, 3);
  MatrixXd moved = still;
  moved(0, 1) = 1.5;
  CHECK(trajectory_error(still, still, peak_displacement(still)) == 0.0);
  CHECK(std::isinf(trajectory_error(moved, still, peak_displacement(still))));
}

TEST("digits are the negative logarithm, between 0 and 17") {
  CHECK_NEAR(digits(1e-9), 9.0, 1e-12);
  CHECK(digits(0.0) == 17.0);
  CHECK(digits(3.0) == 0.0);
  CHECK(digits(std::nan("")) == 0.0);
}

const std::vector<double> times = sample::instants(0.04, 20);
constexpr Tolerance finest_tolerance{.relative = 1e-12};

std::vector<NamedSolver> explicit_and_adams() {
  return {solver_named("arkode-fehlberg-7-8"), solver_named("cvode-adams")};
}

NetworkProblem pulsed(int nodes) {
  return NetworkProblem(sample::block({.nodes = nodes}), {sample::pulse(0.5)});
}

/// Solver that steps over every load.
Trace solve_blindly(const Problem& problem, const std::vector<double>& at,
                    const Tolerance& tolerance) {
  const auto& network = dynamic_cast<const NetworkProblem&>(problem);
  return solve_cvode_adams(NetworkProblem(network.network()), at, tolerance);
}

Trace solve_with_a_nan(const Problem& problem, const std::vector<double>& at,
                       const Tolerance& tolerance) {
  Trace solution = solve_cvode_adams(problem, at, tolerance);
  solution.position(3, 7) = std::numeric_limits<double>::quiet_NaN();
  return solution;
}

Trace solve_never(const Problem&, const std::vector<double>&, const Tolerance&) {
  throw SolverError("planted failure");
}

/// Solver that is accurate only at the coarsest tolerance and diverges with refinement.
Trace solve_worse_when_tighter(const Problem& problem, const std::vector<double>& at,
                               const Tolerance& tolerance) {
  Trace solution = solve_arkode_explicit(problem, at, finest_tolerance);
  if (tolerance.relative > finest_tolerance.relative) {
    solution.position.rightCols(1).array() += 1e-9 / std::sqrt(tolerance.relative);
  }
  return solution;
}

TEST("two families agree to nine digits on a nonlinear lattice under a load of 10 ms") {
  const NetworkProblem problem = pulsed(4);
  const Reference reference =
      establish(problem, times, finest_tolerance, explicit_and_adams(), {.permute_springs = true});
  CHECK(reference.trustworthy);
  CHECK(reference.reason.empty());
  CHECK(reference.agreed_digits >= 9.0);
  CHECK(reference.agreed_velocity_digits >= 9.0);
  CHECK(reference.ladder_is_monotone);
  CHECK(reference.ladder.size() == 3);
  CHECK(reference.solution.steps >= 2 + 10);
  REQUIRE(reference.position_floor.size() == times.size());
  CHECK(reference.position_floor.front() == 0.0);
  CHECK(reference.conditioning_digits.value_or(0.0) >= 11.0);
  CHECK(reference.notes.empty());
  CHECK(!reference.energy_digits);  // damped and loaded
}

TEST("the implicit pair agrees on a lattice with stiff damping") {
  const NetworkProblem problem(sample::block({.nodes = 3, .viscosity = 5.0}), {sample::pulse(0.5)});
  const Reference reference = establish(
      problem, times, {.relative = 1e-11},
      {solver_named("arkode-esdirk-5-4"), solver_named("cvode-bdf")}, {.demanded_digits = 7.0});
  CHECK(reference.trustworthy);
}

TEST("a wrong solver of either family is found") {
  const auto established = [](std::size_t which, auto solve, int rungs) {
    auto families = explicit_and_adams();
    families[which].solve = solve;
    const Reference reference =
        establish(pulsed(3), times, finest_tolerance, families, {.rungs = rungs});
    CHECK(!reference.trustworthy);
    return reference;
  };
  const Reference blind = established(1, solve_blindly, 1);
  CHECK(blind.agreed_digits < 1.0);
  CHECK_CONTAINS(blind.reason, "are demanded");
  for (const std::size_t which : {0U, 1U}) {
    CHECK(established(which, solve_with_a_nan, 1).agreed_digits == 0.0);
  }
  CHECK_CONTAINS(established(1, solve_never, 1).reason, "planted failure");
  CHECK(!established(0, solve_worse_when_tighter, 4).ladder_is_monotone);
}

TEST("a ladder of fewer than four tolerances is noted") {
  const Reference reference =
      establish(pulsed(3), times, finest_tolerance, explicit_and_adams(), {.rungs = 2});
  CHECK(reference.trustworthy);
  CHECK(reference.notes.size() == 1);
}

TEST("two solvers of one family do not make a reference") {
  CHECK_THROWS(establish(pulsed(2), times, finest_tolerance,
                         {solver_named("arkode-fehlberg-7-8"), solver_named("gsl-rk8pd")}),
               "two families");
  CHECK_THROWS(establish(pulsed(2), times, finest_tolerance, {solver_named("cvode-adams")}),
               "two families");
}

TEST("energy of an undamped, unloaded lattice balances to ten digits, weight included") {
  auto network = sample::block({.nodes = 3, .viscosity = 0.0});
  network.initial_velocity = NodeVectors::Zero(3, network.node_count());
  network.initial_velocity.col(0) << 0.3, 0.1, 0.5;
  const NetworkProblem problem(network, {}, {0.0, 0.0, 9.81});
  const Trace solution = solve_arkode_explicit(problem, times, finest_tolerance);
  CHECK(energy_digits(problem, solution).value_or(0.0) >= 10.0);
  const LinearProblem linear(problem);
  const Trace straight = solve_arkode_explicit(linear, times, finest_tolerance);
  CHECK(energy_digits(linear, straight).value_or(0.0) >= 10.0);
  Trace poisoned = solution;
  poisoned.velocity(0, 3) = std::numeric_limits<double>::quiet_NaN();
  CHECK(energy_digits(problem, poisoned).value_or(9.0) == 0.0);
}

TEST("printed forms are not permuted in silence") {
  const NetworkProblem printed(sample::block({.nodes = 3}), {sample::pulse(0.1)}, {0.0, 0.0, 0.0},
                               {.half_force = true});
  const Reference reference = establish(printed, times, finest_tolerance, explicit_and_adams(),
                                        {.rungs = 4, .permute_springs = true});
  CHECK(!reference.conditioning_digits);
  CHECK(reference.notes.size() == 1);
}

const std::vector<double> load_times = sample::instants(0.03, 6);

SpringNetwork moving_block() {
  auto network = sample::block({.nodes = 3});
  const Eigen::Index n = network.node_count();
  network.initial_displacement = NodeVectors::Zero(3, n);
  network.initial_velocity = NodeVectors::Zero(3, n);
  network.initial_displacement.col(4) << 2e-4, -1e-4, 3e-4;
  network.initial_velocity.col(13) << 0.1, 0.05, -0.2;
  return network;
}

std::vector<Load> all_loads() {
  const Load step{.nodes = {3, 5}, .force = {0.0, 0.2, 0.0}, .start = 0.0, .end = 8e-3};
  const Load ramp{.nodes = {7},
                  .force = {0.1, 0.0, 0.2},
                  .start = 2e-3,
                  .end = 12e-3,
                  .profile = Profile::ramp};
  return {sample::pulse(0.5), step, ramp};
}

double disagreement(const Problem& specification, const NetworkProblem& truth) {
  const Trace a = solve_arkode_explicit(specification, load_times, {.relative = 1e-12});
  const Trace b = solve_long_double(truth, load_times, {.relative = 1e-14});
  return trajectory_error(a.position, b.position, peak_displacement(b.position));
}

TEST("the specification and the equations written afresh agree, all terms at work") {
  const NetworkProblem problem(moving_block(), all_loads(), {1.0, -2.0, 9.81});
  CHECK_NEAR(disagreement(problem, problem), 0.0,
             3e-12);  // tolerance 1e-12; positions of 1e-2 m for motions of 5e-4 m
}

TEST("a wrong stiffness, spring, load, damping or printed form of the force law shows") {
  const NetworkProblem truth(moving_block(), all_loads());
  const auto shows = [&](auto change) {
    auto network = moving_block();
    auto loads = all_loads();
    change(network, loads);
    CHECK(disagreement(NetworkProblem(network, loads), truth) > 1e-6);
  };
  shows([](SpringNetwork& n, auto&) {
    n.springs.change_each([](Spring& s) { s.stiffness *= 1.0001; });
  });
  shows([](SpringNetwork& n, auto&) {
    n.springs.change_each([](Spring& s) { s.viscosity *= 0.5; });
  });
  shows([](SpringNetwork& n, auto&) { n.springs.edit([](auto& all) { all.erase(all.begin()); }); });
  shows([](SpringNetwork&, auto& loads) { loads[1].start = 1e-5; });
  for (const PrintedForm& form :
       {PrintedForm{.direction = true}, PrintedForm{.half_force = true}}) {
    const NetworkProblem printed(moving_block(), all_loads(), {0.0, 0.0, 0.0}, form);
    CHECK(disagreement(printed, truth) > 1e-3);
  }
}

TEST("long double improves with the tolerance where double has stopped, for known problems") {
  const NetworkProblem problem(moving_block(), all_loads());
  CHECK_THROWS(solve_long_double(DerivedProblem(problem), load_times, {}),
               "only networks and the oscillator");
  const Trace finest = solve_long_double(problem, load_times, {.relative = 1e-17});
  const double peak = peak_displacement(finest.position);
  double before = 1.0;
  for (const double relative : {1e-8, 1e-10, 1e-12, 1e-14}) {
    const Trace s = solve_long_double(problem, load_times, {.relative = relative});
    const double error = trajectory_error(s.position, finest.position, peak);
    CHECK(error < 0.2 * before);
    before = error;
  }
  CHECK(before < 1e-14);
}

}  // namespace PALPATE_FILE
