// SPDX-License-Identifier: MIT

#include "reference/exact_problems.hpp"

#include "reference/solver_cross_check.hpp"
#include "reference/solvers.hpp"
#include "tests/check.hpp"
#include "tests/reference/sample_problems.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using namespace palpate::reference;
using Eigen::VectorXd;

VectorXd force_of(const Problem& p, double t, double gate, const VectorXd& q, const VectorXd& v) {
  VectorXd f(p.dof());
  p.force(t, gate, q, v, f);
  return f;
}

TEST("the linear problem touches the network at rest: the difference is of second order") {
  const NetworkProblem network(sample::block({.nodes = 3}), {sample::pulse(0.5)});
  const LinearProblem linear(network);
  const VectorXd shape = VectorXd::LinSpaced(network.dof(), -1.0, 1.0).array().sin();
  double before = 0.0;
  for (const double size : {1e-5, 1e-6}) {
    const VectorXd q = rest_coordinates(network) + size * shape;
    const VectorXd v = 100.0 * size * shape.reverse();
    const double difference =
        (force_of(linear, 0.01, 0.01, q, v) - force_of(network, 0.01, 0.01, q, v))
            .cwiseAbs()
            .maxCoeff();
    if (before > 0.0) { CHECK_NEAR(before / difference, 100.0, 3.0); }
    before = difference;
  }
}

TEST("linearising changes nothing of an oscillator, and nothing of what is linear") {
  const OscillatorProblem oscillator(Oscillator{.drive_amplitude = 2.0, .drive_frequency = 3.0});
  const LinearProblem linear(oscillator);
  const VectorXd x = VectorXd::Constant(1, 0.3);
  const VectorXd speed = VectorXd::Constant(1, -0.7);
  CHECK_NEAR(force_of(linear, 0.4, 0.4, x, speed), force_of(oscillator, 0.4, 0.4, x, speed), 1e-15);
  CHECK_NEAR(linear.energy(x, speed), oscillator.energy(x, speed), 1e-15);
  const NetworkProblem network(sample::block({.nodes = 2}), {sample::pulse(0.5)});
  const LinearProblem once(network);
  const LinearProblem twice(once);
  const VectorXd q = once.rest().array() + 1e-3;
  const VectorXd v = VectorXd::Ones(once.dof());
  CHECK(&twice.base() == &network);
  CHECK(force_of(once, 0.01, 0.01, q, v) == force_of(twice, 0.01, 0.01, q, v));
}

TEST("the energy of the linear problem is the work of its forces, weight included") {
  const NetworkProblem network(sample::block({.nodes = 3, .viscosity = 0.0}), {}, {0.0, 0.5, 9.81});
  const LinearProblem linear(network);
  const VectorXd still = VectorXd::Zero(linear.dof());
  const VectorXd direction = VectorXd::LinSpaced(linear.dof(), -1.0, 1.0).array().cos();
  const VectorXd q = linear.rest() + 1e-3 * direction;
  const double h = 1e-5;  // the energy is quadratic: central differences are exact
  const double slope =
      (linear.energy(q + h * direction, still) - linear.energy(q - h * direction, still)) /
      (2.0 * h);
  const double work = -force_of(linear, 0.0, 0.0, q, still).dot(direction);
  CHECK_NEAR(slope / work, 1.0, 1e-10);
}

TEST("rest coordinates are rest positions, whatever the initial displacement") {
  auto network = sample::chain(3, 10.0, 1e-3, false);
  network.initial_displacement = NodeVectors::Constant(3, 4, 1e-3);
  network.initial_displacement.col(0).setZero();
  const NetworkProblem problem(network);
  CHECK_NEAR(rest_coordinates(problem)(2), 0.01, 1e-16);
  CHECK_NEAR(problem.initial_position()(2), 0.011, 1e-16);
}

const NetworkProblem base(sample::block({.nodes = 3}), {sample::pulse(0.5)});
const ManufacturedProblem problem(base, {.amplitude = 3e-4, .frequency = 300.0, .duration = 0.04});

TEST("the chosen motion moves every coordinate differently, and its derivatives and force agree") {
  const VectorXd moved = problem.exact_position(0.02) - base.initial_position();
  for (Eigen::Index i = 1; i < moved.size(); ++i) { CHECK(moved(i) != moved(i - 1)); }
  const double h = 1e-5;
  for (const double t : {0.0, 0.006, 0.013, 0.02, 0.04}) {
    const VectorXd v = (problem.exact_position(t + h) - problem.exact_position(t - h)) / (2.0 * h);
    const VectorXd a = (problem.exact_velocity(t + h) - problem.exact_velocity(t - h)) / (2.0 * h);
    // Central differences: (frequency h)^2 / 6 = 1.5e-6 of speeds of 0.2 and 50 m/s^2.
    CHECK_NEAR(problem.exact_velocity(t), v, 1e-6);
    CHECK_NEAR(problem.exact_acceleration(t), a, 3e-4);
    CHECK_NEAR(force_of(problem, t, t, problem.exact_position(t), problem.exact_velocity(t)),
               problem.mass().cwiseProduct(problem.exact_acceleration(t)), 1e-14);
  }
}

TEST("solvers recover the chosen motion of a nonlinear lattice") {
  const auto times = sample::instants(0.04, 10);
  Trace exact;
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
    const Trace solution = solver_named(name).solve(problem, times, {.relative = 1e-10});
    const double error = trajectory_error(solution.position, exact.position, peak);
    CHECK_NEAR(error, 0.0, limit);
  }
}

}  // namespace PALPATE_FILE
