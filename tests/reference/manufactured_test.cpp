// SPDX-License-Identifier: MIT
#include "reference/manufactured.hpp"

#include "reference/solvers.hpp"
#include "reference/trajectory_error.hpp"
#include "tests/check.hpp"
#include "tests/reference/sample_problems.hpp"

using Eigen::VectorXd;
using palpate::NetworkProblem;
using namespace palpate::reference;

namespace {
const NetworkProblem base(sample::block({.nodes = 3}), {sample::pulse(0.5)});
const ManufacturedProblem problem(base, {.amplitude = 3e-4, .frequency = 300.0, .duration = 0.04});
}  // namespace

TEST("the chosen velocity and acceleration are the derivatives of the chosen position") {
  const double h = 1e-5;
  for (const double t : {0.0, 0.013, 0.04}) {
    const VectorXd v = (problem.exact_position(t + h) - problem.exact_position(t - h)) / (2.0 * h);
    const VectorXd a = (problem.exact_velocity(t + h) - problem.exact_velocity(t - h)) / (2.0 * h);
    // Central differences: (frequency h)^2 / 6 = 1.5e-6 of speeds of 0.2 and 50 m/s^2.
    CHECK_NEAR(problem.exact_velocity(t), v, 1e-6);
    CHECK_NEAR(problem.exact_acceleration(t), a, 3e-4);
  }
}

TEST("along the chosen motion the force is mass times its acceleration") {
  for (const double t : {0.0, 0.006, 0.02}) {
    VectorXd f(problem.dof());
    problem.force(t, t, problem.exact_position(t), problem.exact_velocity(t), f);
    CHECK_NEAR(f, VectorXd(problem.mass().cwiseProduct(problem.exact_acceleration(t))), 1e-14);
  }
}

TEST("solvers recover the chosen motion of a nonlinear lattice") {
  const auto times = sample::instants(0.04, 10);
  Solution exact;
  exact.position.resize(problem.dof(), 11);
  for (Eigen::Index n = 0; n <= 10; ++n) {
    exact.position.col(n) = problem.exact_position(times[static_cast<std::size_t>(n)]);
  }
  const double peak = peak_displacement(exact.position);
  const std::pair<const char*, double> expected[] = {{"arkode-fehlberg-7-8", 1e-10},
                                                     {"gsl-rk8pd", 1e-10},
                                                     {"cvode-adams", 1e-7},
                                                     {"arkode-esdirk-5-4", 1e-8},
                                                     {"cvode-bdf", 1e-6}};
  for (const auto& [name, limit] : expected) {
    const Solution solution = solver_named(name).solve(problem, times, {.relative = 1e-10});
    const double error = trajectory_error(solution.position, exact.position, peak);
    std::printf("  %-22s %.1e\n", name, error);
    CHECK_NEAR(error, 0.0, limit);
  }
}

TEST("the chosen motion moves every coordinate differently") {
  const VectorXd moved = problem.exact_position(0.02) - base.initial_position();
  for (Eigen::Index i = 1; i < moved.size(); ++i) { CHECK(moved(i) != moved(i - 1)); }
}
