// SPDX-License-Identifier: MIT
#include "model/stepping/spectral_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

#include "model/dynamics/spring_force.hpp"

namespace palpate {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Block of one spring between two coordinates (-1: fixed).
struct Block {
  Eigen::Index a;
  Eigen::Index b;
  Matrix3d matrix;
};

enum class Which { stiffness, stretched_stiffness, damping };

/// The spring's k u u^T with its geometric stiffness, all of it or of stretched springs only (which
/// leaves nothing negative and can only raise the frequencies); or its c u u^T.
std::vector<Block> blocks_of(const NetworkProblem& problem, Which which) {
  const NodeVectors place = problem.network().initial_position();
  std::vector<Block> blocks;
  for (const Spring& s : problem.network().springs) {
    const Eigen::Index a = problem.coordinate(s.a);
    const Eigen::Index b = problem.coordinate(s.b);
    const Vector3d d = place.col(s.b) - place.col(s.a);
    const double length = d.norm();
    if ((a < 0 && b < 0) || length < zero_length) { continue; }
    const Matrix3d along = d * d.transpose() / (length * length);
    if (which == Which::damping) {
      if (s.viscosity > 0.0) { blocks.push_back({a, b, s.viscosity * along}); }
      continue;
    }
    double tension = s.stiffness * (length - s.rest_length);
    if (which == Which::stretched_stiffness) { tension = std::max(0.0, tension); }
    const Matrix3d across = Matrix3d::Identity() - along;
    blocks.push_back({a, b, s.stiffness * along + tension / length * across});
  }
  return blocks;
}

/// y = M^-1 (sum of blocks) x.
void apply(const std::vector<Block>& blocks, const VectorXd& mass, const VectorXd& x, VectorXd& y) {
  y.setZero();
  for (const Block& block : blocks) {
    Vector3d difference = Vector3d::Zero();
    if (block.a >= 0) { difference -= x.segment<3>(block.a); }
    if (block.b >= 0) { difference += x.segment<3>(block.b); }
    const Vector3d f = block.matrix * difference;
    if (block.a >= 0) { y.segment<3>(block.a) -= f; }
    if (block.b >= 0) { y.segment<3>(block.b) += f; }
  }
  y.array() /= mass.array();
}

/// Fixed, with every wave length in it.
VectorXd start_vector(Eigen::Index size) {
  VectorXd x(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    x(i) = std::cos(1.0 + 12.9898 * static_cast<double>(i)) + (i % 2 == 0 ? 0.3 : -0.3);
  }
  return x;
}

/// Largest eigenvalue of M^-1 B from below, and its vector, from a first guess at it. The Rayleigh
/// quotient in the M inner product can only fall short of it.
double power_iteration(const std::vector<Block>& blocks, const VectorXd& mass, VectorXd& x) {
  VectorXd y(x.size());
  double largest = 0.0;
  double quotient = 0.0;
  for (int n = 0; n < 500; ++n) {
    x /= std::sqrt(x.dot(mass.cwiseProduct(x)));
    apply(blocks, mass, x, y);
    const double next = x.dot(mass.cwiseProduct(y));
    x.swap(y);
    const bool settled = std::abs(next - quotient) <= 1e-9 * std::abs(next);
    quotient = next;
    largest = std::max(largest, quotient);
    if (settled) { break; }
  }
  return largest;
}

/// For any positive weights w, |x_a - x_b|_B^2 <= (1 + w_b/w_a) |x_a|_B^2 + (1 + w_a/w_b) |x_b|_B^2,
/// so no eigenvalue of M^-1 B exceeds the largest over nodes of lambda_max(sum (1 + w_b/w_a) B) / m.
double bound_with_weights(const std::vector<Block>& blocks, const VectorXd& mass,
                          const VectorXd& weight) {
  std::vector<Matrix3d> sums(static_cast<std::size_t>(mass.size() / 3), Matrix3d::Zero());
  const auto add = [&](Eigen::Index self, Eigen::Index other, const Matrix3d& matrix) {
    if (self < 0) { return; }
    const double factor = other < 0 ? 1.0 : 1.0 + weight(other / 3) / weight(self / 3);
    sums[static_cast<std::size_t>(self / 3)] += factor * matrix;
  };
  for (const Block& block : blocks) {
    add(block.a, block.b, block.matrix);
    add(block.b, block.a, block.matrix);
  }
  double largest = 0.0;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const double top =
        Eigen::SelfAdjointEigenSolver<Matrix3d>(sums[i], Eigen::EigenvaluesOnly).eigenvalues()(2);
    largest = std::max(largest, top / mass(static_cast<Eigen::Index>(3 * i)));
  }
  return largest;
}

struct Extreme {
  double estimate;
  double upper;
};

/// The best of three choices of weights: equal, inverse masses (exact for one spring), and the
/// shape of the fastest mode with a floor under it.
Extreme largest_eigenvalue(const std::vector<Block>& blocks, const VectorXd& mass) {
  if (blocks.empty()) { return {0.0, 0.0}; }
  const Eigen::Index nodes = mass.size() / 3;
  VectorXd x = start_vector(mass.size());
  const double estimate = power_iteration(blocks, mass, x);
  VectorXd node_mass(nodes);
  VectorXd amplitude(nodes);
  for (Eigen::Index i = 0; i < nodes; ++i) {
    node_mass(i) = mass(3 * i);
    amplitude(i) = x.segment<3>(3 * i).norm();
  }
  double upper = bound_with_weights(blocks, mass, VectorXd::Ones(nodes));
  upper = std::min(upper, bound_with_weights(blocks, mass, node_mass.cwiseInverse()));
  for (const double floor : {0.3, 0.1, 0.03}) {
    const VectorXd weight =
        (amplitude.array() / amplitude.maxCoeff() + floor).matrix();
    if (weight.allFinite()) { upper = std::min(upper, bound_with_weights(blocks, mass, weight)); }
  }
  return {estimate, upper * (1.0 + 1e-12)};
}

/// Compressed springs lower the frequencies, so the bound above leaves that out and the estimate
/// does not.
Extreme stiffness_extreme(const NetworkProblem& problem) {
  const VectorXd& mass = problem.mass();
  Extreme extreme = largest_eigenvalue(blocks_of(problem, Which::stretched_stiffness), mass);
  if (extreme.upper > 0.0) {
    VectorXd x = start_vector(mass.size());
    extreme.estimate = power_iteration(blocks_of(problem, Which::stiffness), mass, x);
  }
  return extreme;
}

}  // namespace

SpectralBounds spectral_bounds(const NetworkProblem& problem) {
  SpectralBounds bounds;
  const Extreme stiffness = stiffness_extreme(problem);
  const Extreme damping = largest_eigenvalue(blocks_of(problem, Which::damping), problem.mass());
  bounds.omega_estimate = std::sqrt(stiffness.estimate);
  bounds.omega_upper = std::sqrt(stiffness.upper);
  bounds.damping_upper = damping.upper;
  bounds.relaxation_lower = std::numeric_limits<double>::infinity();
  for (const Spring& s : problem.network().springs) {
    if (s.stiffness > 0.0) {
      bounds.relaxation_lower = std::min(bounds.relaxation_lower, s.viscosity / s.stiffness);
    }
  }
  if (!std::isfinite(bounds.relaxation_lower)) { bounds.relaxation_lower = 0.0; }
  return bounds;
}

SpectralBounds spectral_bounds(const Oscillator& o) {
  const double omega = std::sqrt(o.stiffness / o.mass);
  return {omega, omega, o.viscosity / o.mass, o.stiffness > 0.0 ? o.viscosity / o.stiffness : 0.0};
}

}  // namespace palpate
