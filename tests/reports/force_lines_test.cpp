// SPDX-License-Identifier: MIT
#include "reports/force_lines.hpp"

#include "tests/check.hpp"

using namespace palpate;

namespace {

/// Nodes in a row along `direction`, 1 m apart, the last one fixed.
SpringNetwork row(const Eigen::Vector3d& direction, int nodes, double stiffness) {
  SpringNetwork network;
  network.rest_position.resize(3, nodes);
  for (int n = 0; n < nodes; ++n) { network.rest_position.col(n) = n * direction; }
  network.mass = Eigen::VectorXd::Ones(nodes);
  network.fixed.assign(static_cast<std::size_t>(nodes), 0);
  network.fixed.back() = 1;
  for (int n = 0; n + 1 < nodes; ++n) { network.springs.push_back({n, n + 1, stiffness, 7.0, 1.0}); }
  return network;
}

}  // namespace

TEST("inside a chain the principal force is the chain's tension, along the chain") {
  const Eigen::Vector3d direction = Eigen::Vector3d(1.0, 2.0, 2.0) / 3.0;
  const SpringNetwork network = row(direction, 4, 50.0);
  for (const double stretch : {0.1, -0.1}) {
    const NodeVectors position = (1.0 + stretch) * network.rest_position;
    const ForceLines lines = force_lines(network, {}, position);
    const double tension = 50.0 * stretch;
    CHECK_NEAR(lines.line(3, 1), tension, 1e-5);        // single precision
    CHECK_NEAR(lines.line(3, 0), 0.5 * tension, 1e-5);  // one spring only
    CHECK_NEAR(std::abs(lines.line.col(2).head<3>().cast<double>().dot(direction)), 1.0, 1e-6);
    CHECK_NEAR(lines.held, Eigen::Vector3d(-tension * direction), 1e-12);
  }
}

TEST("the force furthest from zero is told where a node is pulled one way and pushed the other") {
  SpringNetwork network = row(Eigen::Vector3d::UnitX(), 3, 10.0);
  network.rest_position.col(2) << 1.0, 1.0, 0.0;
  NodeVectors position = network.rest_position;
  position(0, 0) -= 0.1;  // pulls along x
  position(1, 2) -= 0.3;  // pushes along y
  const ForceLines lines = force_lines(network, {}, position);
  CHECK_NEAR(lines.line(3, 1), -1.5, 1e-6);
  CHECK_NEAR(std::abs(lines.line(1, 1)), 1.0, 1e-6);
}

TEST("at rest, and with springs of no length, nothing pulls") {
  SpringNetwork network = row(Eigen::Vector3d::UnitZ(), 3, 10.0);
  CHECK(force_lines(network, {}, network.rest_position).line.isZero(0.0F));
  NodeVectors position = NodeVectors::Zero(3, 3);
  CHECK(force_lines(network, {}, position).line.isZero(0.0F));
}

TEST("the printed law with its wrong sign is shown as it was simulated") {
  const SpringNetwork network = row(Eigen::Vector3d::UnitX(), 3, 10.0);
  const NodeVectors position = 1.1 * network.rest_position;
  const ForceLines lines = force_lines(network, SpringLaw::from({.sign = true}), position);
  CHECK_NEAR(lines.line(3, 1), -1.0, 1e-6);
}
