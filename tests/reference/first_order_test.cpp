// SPDX-License-Identifier: MIT
#include "reference/first_order.hpp"

#include <random>

#include "tests/check.hpp"
#include "tests/reference/sample_problems.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using palpate::NetworkProblem;
using palpate::reference::FirstOrderJacobian;
using palpate::reference::FirstOrderSystem;

namespace {

const NetworkProblem network(sample::block({.nodes = 3, .viscosity = 0.5}), {sample::pulse(0.5)});

/// Strongly deformed (a tenth of the spacing) and moving, so that every term of J is at work.
VectorXd deformed_state(Index dof) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  VectorXd y(2 * dof);
  for (Index i = 0; i < dof; ++i) { y(i) = 5e-4 * unit(random); }
  for (Index i = dof; i < 2 * dof; ++i) { y(i) = 0.5 * unit(random); }
  return y;
}

MatrixXd dense(const FirstOrderJacobian& jacobian) {
  const auto n = static_cast<Index>(jacobian.size());
  MatrixXd matrix = MatrixXd::Zero(n, n);
  for (Index j = 0; j < n; ++j) {
    const auto c = static_cast<std::size_t>(j);
    for (auto k = jacobian.column_starts()[c]; k < jacobian.column_starts()[c + 1]; ++k) {
      matrix(jacobian.rows()[static_cast<std::size_t>(k)], j) +=
          jacobian.values()[static_cast<std::size_t>(k)];
    }
  }
  return matrix;
}

/// Central differences of the derivative, of fourth order.
MatrixXd differences(FirstOrderSystem& system, const VectorXd& y) {
  const Index n = system.size();
  MatrixXd matrix(n, n);
  for (Index j = 0; j < n; ++j) {
    const double h = j < system.dof() ? 1e-6 : 1e-3;
    const auto at = [&](double by) {
      VectorXd moved = y;
      moved(j) += by;
      VectorXd dy(n);
      CHECK(system.derivative(0.0, moved.data(), dy.data()));
      return dy;
    };
    matrix.col(j) = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
  }
  return matrix;
}

}  // namespace

TEST("the first-order system is velocity and force over mass") {
  FirstOrderSystem system(network);
  const VectorXd y = deformed_state(network.dof());
  VectorXd dy(system.size()), force(network.dof());
  system.set_gate(0.01);
  CHECK(system.derivative(0.011, y.data(), dy.data()));
  network.force(0.011, 0.01, network.initial_position() + y.head(network.dof()),
                y.tail(network.dof()), force);
  CHECK(dy.head(network.dof()) == y.tail(network.dof()));
  // One division against one multiplication by the inverse: two roundings.
  CHECK_NEAR(dy.tail(network.dof()).cwiseProduct(network.mass()), force,
             4e-16 * force.cwiseAbs().maxCoeff());
  CHECK(system.evaluations() == 1);
}

TEST("the sparse Jacobian equals differences of the right-hand side, deformed and moving") {
  FirstOrderSystem system(network);
  const VectorXd y = deformed_state(network.dof());
  FirstOrderJacobian jacobian(system);
  jacobian.update(y.data());
  const MatrixXd expected = differences(system, y);
  // Fourth-order differences leave about (rounding / h)^(4/5); 1e-7 of the largest entry.
  CHECK_NEAR(dense(jacobian) / expected.cwiseAbs().maxCoeff(),
             expected / expected.cwiseAbs().maxCoeff(), 1e-8);
  const Index n = network.dof();
  const MatrixXd drag = expected.bottomRightCorner(n, n);
  CHECK_NEAR(dense(jacobian).bottomRightCorner(n, n) / drag.cwiseAbs().maxCoeff(),
             drag / drag.cwiseAbs().maxCoeff(), 1e-8);
}

TEST("the Jacobian's pattern holds the whole diagonal even without damping") {
  const NetworkProblem undamped(sample::chain(5, 100.0, 1e-3, false));
  const FirstOrderSystem system(undamped);
  const FirstOrderJacobian jacobian(system);
  for (std::int64_t j = 0; j < jacobian.size(); ++j) {
    bool found = false;
    const auto c = static_cast<std::size_t>(j);
    for (auto k = jacobian.column_starts()[c]; k < jacobian.column_starts()[c + 1]; ++k) {
      found = found || jacobian.rows()[static_cast<std::size_t>(k)] == j;
    }
    CHECK(found);
  }
}

TEST("a right-hand side that is not finite is reported") {
  FirstOrderSystem system(network);
  VectorXd y = deformed_state(network.dof());
  VectorXd dy(system.size());
  y(3) = std::nan("");
  CHECK(!system.derivative(0.0, y.data(), dy.data()));
}
