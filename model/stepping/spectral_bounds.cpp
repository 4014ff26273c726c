// SPDX-License-Identifier: MIT
#include "model/stepping/spectral_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

#include "model/stepping/lanczos.hpp"
#include "model/stepping/spring_blocks.hpp"

namespace palpate {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using spring_blocks::roundings;
using spring_blocks::visit_blocks;
using spring_blocks::Which;

/// Of a symmetric matrix: xx, xy, xz, yy, yz, zz.
using Upper = Eigen::Matrix<double, 6, 1>;
Upper upper_of(const Matrix3d& m) {
  Upper upper;
  upper << m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2);
  return upper;
}
Matrix3d whole_of(const Upper& m) {
  Matrix3d whole;
  whole << m(0), m(1), m(2), m(1), m(3), m(4), m(2), m(4), m(5);
  return whole;
}

struct Fastest {
  double bound = 0.0;
  Eigen::Index free_node = 0;  ///< that it comes from
};

/// For any positive weights w, |x_a - x_b|_B^2 <= (1 + w_b/w_a) |x_a|_B^2 + (1 + w_a/w_b) |x_b|_B^2,
/// so no eigenvalue of M^-1 B exceeds the largest over nodes of lambda_max(sum (1 + w_b/w_a) B) / m.
Fastest bound_with_weights(const NetworkProblem& problem, Which which, const VectorXd& weight) {
  const VectorXd& mass = problem.mass();
  std::vector<Upper> sums(static_cast<std::size_t>(mass.size() / 3), Upper::Zero());
  const auto add = [&](Eigen::Index self, Eigen::Index other, const Matrix3d& matrix) {
    if (self < 0) { return; }
    const double factor = other < 0 ? 1.0 : 1.0 + weight(other / 3) / weight(self / 3);
    sums[static_cast<std::size_t>(self / 3)] += factor * upper_of(matrix);
  };
  const auto everywhere = [](Eigen::Index) { return true; };
  visit_blocks(problem, which, {}, everywhere, [&](Eigen::Index a, Eigen::Index b, const Matrix3d& matrix) {
    add(a, b, matrix);
    add(b, a, matrix);
  });
  Fastest fastest;
  Upper before = Upper::Zero();  // of the last node that was looked at, over its mass
  for (std::size_t i = 0; i < sums.size(); ++i) {
    // No eigenvalue exceeds the largest sum of a row's magnitudes, which spares most nodes of a lattice.
    const auto at = static_cast<Eigen::Index>(i);
    const Matrix3d sum = whole_of(sums[i]);
    const double most = sum.cwiseAbs().rowwise().sum().maxCoeff() / mass(3 * at);
    if (most <= fastest.bound * (1.0 + roundings)) { continue; }
    const Upper now = sums[i] / mass(3 * at);
    // An eigenvalue differs by no more than the entries together.
    if ((now - before).cwiseAbs().sum() <= 0.1 * roundings * fastest.bound) { continue; }
    before = now;
    const double top =
        Eigen::SelfAdjointEigenSolver<Matrix3d>(sum, Eigen::EigenvaluesOnly).eigenvalues()(2);
    if (!(top / mass(3 * at) <= fastest.bound)) { fastest = {top / mass(3 * at), at}; }
  }
  return fastest;
}

struct Extreme {
  double estimate;
  double upper;
  Eigen::Index free_node = 0;  ///< that looks fastest
};

/// The best of three choices of weights: equal, inverse masses (exact for one spring), and, where modes of
/// the whole network are sought, the shape of the fastest with a floor under it.
Extreme largest_eigenvalue(const NetworkProblem& problem, Which which) {
  const VectorXd& mass = problem.mass();
  const Eigen::Index nodes = mass.size() / 3;
  const Fastest equal = bound_with_weights(problem, which, VectorXd::Ones(nodes));
  if (!(equal.bound > 0.0)) { return {0.0, 0.0}; }
  double upper = equal.bound;
  if (mass.minCoeff() < mass.maxCoeff()) {  // else the weights are equal once more
    const VectorXd inverse_mass =
        Eigen::Map<const VectorXd, 0, Eigen::InnerStride<3>>(mass.data(), nodes).cwiseInverse();
    upper = std::min(upper, bound_with_weights(problem, which, inverse_mass).bound);
  }
  const Part part = whole_or_part(problem, equal.free_node);
  Lanczos lanczos(problem, which, part);
  const double estimate = lanczos.largest();
  if (part.mass.size() < mass.size()) { return {estimate, upper * (1.0 + 2.0 * roundings), equal.free_node}; }
  const VectorXd x = lanczos.vector();
  VectorXd amplitude(nodes);
  for (Eigen::Index i = 0; i < nodes; ++i) { amplitude(i) = x.segment<3>(3 * i).norm(); }
  for (const double floor : {0.3, 0.1, 0.03}) {
    const VectorXd weight =
        (amplitude.array() / amplitude.maxCoeff() + floor).matrix();
    if (weight.allFinite()) { upper = std::min(upper, bound_with_weights(problem, which, weight).bound); }
  }
  return {estimate, upper * (1.0 + 2.0 * roundings), equal.free_node};
}

bool any_compressed(const NetworkProblem& problem) {
  constexpr double counts = 1e-9;  // less changes no digit of a frequency that anybody reads
  const NodeVectors& place = problem.held_position();
  return std::ranges::any_of(problem.network().springs, [&](const Spring& s) {
    const double least = (1.0 - counts) * s.rest_length;
    return (place.col(s.b) - place.col(s.a)).squaredNorm() < least * least;
  });
}

/// Compressed springs lower the frequencies, so the bound above leaves that out and the estimate
/// does not.
Extreme stiffness_extreme(const NetworkProblem& problem) {
  Extreme extreme = largest_eigenvalue(problem, Which::stretched_stiffness);
  if (extreme.upper > 0.0 && any_compressed(problem)) {
    const Part part = whole_or_part(problem, extreme.free_node);
    extreme.estimate = Lanczos(problem, Which::stiffness, part).largest();
  }
  return extreme;
}

}  // namespace

SpectralBounds spectral_bounds(const NetworkProblem& problem) {
  SpectralBounds bounds;
  const Extreme stiffness = stiffness_extreme(problem);
  const Extreme damping = largest_eigenvalue(problem, Which::damping);
  bounds.omega_estimate = std::sqrt(stiffness.estimate);
  bounds.omega_upper = std::sqrt(stiffness.upper);
  bounds.damping_upper = damping.upper;
  bounds.relaxation_lower = std::numeric_limits<double>::infinity();
  for (const SpringList::Bond& bond : problem.network().springs.kinds()) {
    if (bond.stiffness > 0.0) {
      bounds.relaxation_lower = std::min(bounds.relaxation_lower, bond.viscosity / bond.stiffness);
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
