// SPDX-License-Identifier: MIT
#include <Eigen/Geometry>

#include "model/dynamics/problem.hpp"
#include "tests/check.hpp"
#include "tests/model/random_network.hpp"

namespace {

using namespace palpate;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd force_of(const NetworkProblem& problem, const VectorXd& q, const VectorXd& v) {
  VectorXd f(problem.dof());
  problem.force(0.0, 0.0, q, v, f);
  return f;
}

VectorXd moved(const NetworkProblem& problem, Random& random) {
  return problem.initial_position() + random.vector(problem.dof(), 2e-3);
}

// Truncation of the central difference (~1e-9) and rounding (eps / delta ~ 1e-9) of forces of 1 N.
constexpr double delta = 1e-7;
constexpr double difference_error = 1e-6;

template <class Function>
MatrixXd numerical_derivative(const VectorXd& at, Function function) {
  MatrixXd result(at.size(), at.size());
  for (Eigen::Index i = 0; i < at.size(); ++i) {
    VectorXd up = at;
    VectorXd down = at;
    up(i) += delta;
    down(i) -= delta;
    result.col(i) = (function(up) - function(down)) / (up(i) - down(i));
  }
  return result;
}

const PrintedForm forms[] = {{},
                             {.sign = true},
                             {.sign = true, .reversed = true},
                             {.direction = true},
                             {.half_force = true},
                             {.sign = true, .direction = true, .half_force = true}};

TEST("K and C are the derivatives of the force, in every printed form") {
  for (const PrintedForm& form : forms) {
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
      const NetworkProblem problem(random_network(seed), {}, Eigen::Vector3d(0, 0, 9.81), form);
      Random random(seed + 100);
      const VectorXd q = moved(problem, random);
      const VectorXd v = random.vector(problem.dof(), 0.5);
      Eigen::SparseMatrix<double> stiffness;
      Eigen::SparseMatrix<double> damping;
      problem.jacobian(q, v, stiffness, damping);
      const MatrixXd k =
          -numerical_derivative(q, [&](const VectorXd& x) { return force_of(problem, x, v); });
      const MatrixXd c =
          -numerical_derivative(v, [&](const VectorXd& x) { return force_of(problem, q, x); });
      CHECK_NEAR(MatrixXd(stiffness), k, difference_error * k.norm());
      CHECK_NEAR(MatrixXd(damping), c, difference_error * c.norm());
    }
  }
}

TEST("the pattern of K and C does not depend on the state") {
  const NetworkProblem problem(random_network(4));
  Random random(5);
  Eigen::SparseMatrix<double> k0, c0, k1, c1;
  problem.jacobian(problem.initial_position(), VectorXd::Zero(problem.dof()), k0, c0);
  problem.jacobian(moved(problem, random), random.vector(problem.dof(), 1.0), k1, c1);
  CHECK(k0.nonZeros() == k1.nonZeros() && c0.nonZeros() == c1.nonZeros());
  CHECK(k0.nonZeros() == c0.nonZeros());
}

TEST("K at rest velocity and C are symmetric") {
  const NetworkProblem problem(random_network(6));
  Random random(7);
  Eigen::SparseMatrix<double> k, c;
  problem.jacobian(moved(problem, random), VectorXd::Zero(problem.dof()), k, c);
  CHECK_NEAR(MatrixXd(k), MatrixXd(k.transpose()), 1e-13 * k.norm());
  CHECK_NEAR(MatrixXd(c), MatrixXd(c.transpose()), 1e-15 * c.norm());
}

TEST("forces of a free network have no resultant and no torque") {
  for (const std::uint64_t seed : {8u, 9u, 10u}) {
    const NetworkProblem problem(random_network(seed, {.fixed = 0}));
    Random random(seed);
    const VectorXd q = moved(problem, random);
    const VectorXd f = force_of(problem, q, random.vector(problem.dof(), 1.0));
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Vector3d torque = Eigen::Vector3d::Zero();
    for (Eigen::Index i = 0; i < f.size(); i += 3) {
      sum += f.segment<3>(i);
      torque += q.segment<3>(i).cross(f.segment<3>(i));
    }
    CHECK_NEAR(sum.norm(), 0.0, 1e-14 * f.norm());            // a few roundings of the largest
    CHECK_NEAR(torque.norm(), 0.0, 1e-14 * f.norm() * 0.02);  // times the size of the body
  }
}

TEST("the undamped force is the negative gradient of the energy") {
  const NetworkProblem problem(random_network(11, {.viscosity = 0.0}), {},
                               Eigen::Vector3d(0.0, 1.0, 9.81));
  Random random(12);
  const VectorXd q = moved(problem, random);
  const VectorXd v = VectorXd::Zero(problem.dof());
  const VectorXd f = force_of(problem, q, v);
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    VectorXd up = q;
    VectorXd down = q;
    up(i) += 1e-6;
    down(i) -= 1e-6;
    const double slope = (problem.energy(up, v) - problem.energy(down, v)) / (up(i) - down(i));
    CHECK_NEAR(-slope, f(i), 1e-6 * f.norm());
  }
}

TEST("dampers take power and never give any") {
  for (const std::uint64_t seed : {13u, 14u, 15u, 16u}) {
    const NetworkProblem damped(random_network(seed));
    Random random(seed);
    const VectorXd q = moved(damped, random);
    const VectorXd v = random.vector(damped.dof(), 1.0);
    const VectorXd drag =
        force_of(damped, q, v) - force_of(damped, q, VectorXd::Zero(damped.dof()));
    CHECK(drag.dot(v) < 0.0);
  }
}

TEST("fixed nodes have no coordinate, hold their initial place and move nothing of their own") {
  SpringNetwork network = random_network(17);
  network.initial_displacement = NodeVectors::Constant(3, network.node_count(), 1e-3);
  const NetworkProblem problem(network);
  CHECK(problem.coordinate(0) == -1 && problem.coordinate(3) == -1 && problem.coordinate(1) == 0);
  CHECK(problem.dof() == 3 * (network.node_count() - 2));
  CHECK_NEAR(Eigen::Vector3d(problem.initial_position().segment<3>(0)),
             Eigen::Vector3d(network.rest_position.col(1).array() + 1e-3), 0.0);
  CHECK_NEAR(problem.mass()(0), network.mass(1), 0.0);
}

TEST("a common displacement of all nodes changes no spring force") {
  SpringNetwork network = random_network(18);
  const NetworkProblem before(network);
  network.initial_displacement = NodeVectors::Constant(3, network.node_count(), 0.25);
  const NetworkProblem after(network);
  const VectorXd still = VectorXd::Zero(before.dof());
  const VectorXd f = force_of(before, before.initial_position(), still);
  // Positions of 0.25 m round to 3e-17 m, times the stiffest spring of 1e3 N/m, times 10 springs.
  CHECK_NEAR(force_of(after, after.initial_position(), still), f, 1e-12);
}

}  // namespace
