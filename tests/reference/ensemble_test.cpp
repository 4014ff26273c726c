// SPDX-License-Identifier: MIT
#include "reference/ensemble.hpp"

#include <limits>

#include "reference/arkode.hpp"
#include "reference/cvode.hpp"
#include "reference/linear_problem.hpp"
#include "tests/check.hpp"
#include "tests/reference/sample_problems.hpp"

using palpate::NetworkProblem;
using palpate::Problem;
using namespace palpate::reference;

namespace {

const std::vector<double> times = sample::instants(0.04, 20);
constexpr Tolerance finest{.relative = 1e-12};

std::vector<NamedSolver> explicit_and_adams() {
  return {solver_named("arkode-fehlberg-7-8"), solver_named("cvode-adams")};
}

NetworkProblem pulsed(int nodes) {
  return NetworkProblem(sample::block({.nodes = nodes}), {sample::pulse(0.5)});
}

/// A solver that steps over every load.
Solution solve_blindly(const Problem& problem, const std::vector<double>& at,
                       const Tolerance& tolerance) {
  const auto& network = dynamic_cast<const NetworkProblem&>(problem);
  return solve_cvode_adams(NetworkProblem(network.network()), at, tolerance);
}

Solution solve_with_a_nan(const Problem& problem, const std::vector<double>& at,
                          const Tolerance& tolerance) {
  Solution solution = solve_cvode_adams(problem, at, tolerance);
  solution.position(3, 7) = std::numeric_limits<double>::quiet_NaN();
  return solution;
}

Solution solve_never(const Problem&, const std::vector<double>&, const Tolerance&) {
  throw SolverError("planted failure");
}

/// Good only at the coarsest tolerance: its ladder leads away from the answer.
Solution solve_worse_when_tighter(const Problem& problem, const std::vector<double>& at,
                                  const Tolerance& tolerance) {
  Solution solution = solve_arkode_explicit(problem, at, finest);
  if (tolerance.relative > finest.relative) {
    solution.position.rightCols(1).array() += 1e-9 / std::sqrt(tolerance.relative);
  }
  return solution;
}

}  // namespace

TEST("two families agree to nine digits on a nonlinear lattice under a load of 10 ms") {
  const NetworkProblem problem = pulsed(4);
  const Reference reference =
      establish(problem, times, finest, explicit_and_adams(), {.permute_springs = true});
  std::printf("  agreed %.1f and %.1f digits, permuted %.1f\n", reference.agreed_digits,
              reference.agreed_velocity_digits, reference.conditioning_digits.value_or(0.0));
  CHECK(reference.trustworthy);
  CHECK(reference.reason.empty());
  CHECK(reference.agreed_digits >= 9.0);
  CHECK(reference.agreed_velocity_digits >= 9.0);
  CHECK(reference.ladder_is_monotone);
  CHECK(reference.ladder.size() == 3);
  CHECK(reference.solution.steps >= 2 + 10);
  CHECK(reference.position_floor.size() == times.size());
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
  std::printf("  agreed %.1f digits\n", reference.agreed_digits);
  CHECK(reference.trustworthy);
}

TEST("a second solver that skips the load is found") {
  auto families = explicit_and_adams();
  families[1].solve = solve_blindly;
  const Reference reference = establish(pulsed(3), times, finest, families, {.rungs = 1});
  CHECK(!reference.trustworthy);
  CHECK(reference.agreed_digits < 1.0);
  CHECK(reference.reason.find("are demanded") != std::string::npos);
}

TEST("a NaN at one coordinate and instant of either solver is found") {
  for (const std::size_t which : {0U, 1U}) {
    auto families = explicit_and_adams();
    families[which].solve = solve_with_a_nan;
    const Reference reference = establish(pulsed(3), times, finest, families, {.rungs = 1});
    CHECK(!reference.trustworthy);
    CHECK(reference.agreed_digits == 0.0);
  }
}

TEST("a second opinion that fails is a reason and not a crash") {
  auto families = explicit_and_adams();
  families[1].solve = solve_never;
  const Reference reference = establish(pulsed(3), times, finest, families, {.rungs = 1});
  CHECK(!reference.trustworthy);
  CHECK(reference.reason.find("planted failure") != std::string::npos);
}

TEST("a ladder that leads away is found") {
  auto families = explicit_and_adams();
  families[0].solve = solve_worse_when_tighter;
  const Reference reference = establish(pulsed(3), times, finest, families);
  CHECK(!reference.ladder_is_monotone);
  CHECK(!reference.trustworthy);
}

TEST("a ladder of fewer than four tolerances is noted") {
  const Reference reference =
      establish(pulsed(3), times, finest, explicit_and_adams(), {.rungs = 2});
  CHECK(reference.trustworthy);
  CHECK(reference.notes.size() == 1);
}

TEST("two solvers of one family do not make a reference") {
  CHECK_THROWS(establish(pulsed(2), times, finest,
                         {solver_named("arkode-fehlberg-7-8"), solver_named("gsl-rk8pd")}),
               "two families");
  CHECK_THROWS(establish(pulsed(2), times, finest, {solver_named("cvode-adams")}), "two families");
}

TEST("energy of an undamped, unloaded lattice balances to ten digits, weight included") {
  auto network = sample::block({.nodes = 3, .viscosity = 0.0});
  network.initial_velocity = palpate::NodeVectors::Zero(3, network.node_count());
  network.initial_velocity.col(0) << 0.3, 0.1, 0.5;
  const NetworkProblem problem(network, {}, {0.0, 0.0, 9.81});
  const Solution solution = solve_arkode_explicit(problem, times, finest);
  std::printf("  %.1f digits\n", energy_digits(problem, solution).value_or(0.0));
  CHECK(energy_digits(problem, solution).value_or(0.0) >= 10.0);
  const LinearProblem linear(problem);
  const Solution straight = solve_arkode_explicit(linear, times, finest);
  CHECK(energy_digits(linear, straight).value_or(0.0) >= 10.0);
  Solution poisoned = solution;
  poisoned.velocity(0, 3) = std::numeric_limits<double>::quiet_NaN();
  CHECK(energy_digits(problem, poisoned).value_or(9.0) == 0.0);
}

TEST("printed forms are not permuted in silence") {
  const NetworkProblem printed(sample::block({.nodes = 3}), {sample::pulse(0.1)}, {0.0, 0.0, 0.0},
                               {.half_force = true});
  const Reference reference = establish(printed, times, finest, explicit_and_adams(),
                                        {.rungs = 4, .permute_springs = true});
  CHECK(!reference.conditioning_digits);
  CHECK(reference.notes.size() == 1);
}
