// SPDX-License-Identifier: MIT
#include "model/stepping/spectral_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <Eigen/Eigenvalues>

#include "model/stepping/spring_blocks.hpp"

namespace palpate {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using spring_blocks::NodeRange;
using spring_blocks::roundings;
using spring_blocks::visit_blocks;
using spring_blocks::Which;

/// Block of one spring between two coordinates (-1: fixed).
struct Block {
  Eigen::Index a;
  Eigen::Index b;
  Matrix3d matrix;
};

/// Part of a problem's coordinates, in which all others stand still. No motion of the part is faster than the
/// fastest of the whole, so what it says is said of the whole from below.
struct Part {
  std::vector<Eigen::Index> coordinate;  ///< by that of the whole: in the part, or -1
  VectorXd mass;                         ///< [kg]
  NodeRange nodes;
};

std::vector<Block> blocks_of(const NetworkProblem& problem, Which which, const Part& part) {
  const auto in_part = [&](Eigen::Index c) {
    return c < 0 ? c : part.coordinate[static_cast<std::size_t>(c)];
  };
  std::vector<Block> blocks;
  const auto wanted = [&](Eigen::Index c) { return in_part(c) >= 0; };
  visit_blocks(problem, which, part.nodes, wanted, [&](Eigen::Index a, Eigen::Index b, const Matrix3d& matrix) {
    blocks.push_back({in_part(a), in_part(b), matrix});
  });
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

/// Lanczos' method for M^-1 B in the M inner product, three vectors at a time; going through it again with
/// the coordinates of a Ritz vector adds that vector up.
class Lanczos {
 public:
  Lanczos(const std::vector<Block>& blocks, const VectorXd& mass) : blocks_(blocks), mass_(mass) {}

  /// Largest eigenvalue, from below: a Ritz value can only fall short of it.
  double largest() {
    begin();
    double value = 0.0;
    for (int n = 0; n < most; ++n) {
      advance();
      const bool look = n % 8 == 7 || n + 1 == most || !(beta_.back() > 0.0);
      if (!look) { continue; }
      const auto steps = static_cast<Eigen::Index>(alpha_.size());
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz;
      ritz.computeFromTridiagonal(Eigen::Map<const VectorXd>(alpha_.data(), steps),
                                  Eigen::Map<const VectorXd>(beta_.data(), steps - 1));
      value = ritz.eigenvalues()(steps - 1);
      ritz_ = ritz.eigenvectors().col(steps - 1);
      // What the vector is off by; the value is off by its square.
      if (!(beta_.back() * std::abs(ritz_(steps - 1)) > accuracy * value)) { break; }
    }
    return value * (1.0 - roundings);
  }
  /// The vector of the value that largest() found.
  VectorXd vector() {
    begin();
    VectorXd sum = VectorXd::Zero(mass_.size());
    for (const double share : ritz_) {
      sum += share * now_;
      advance();
    }
    return sum;
  }

 private:
  static constexpr int most = 200;
  static constexpr double accuracy = 1e-5;

  void begin() {
    now_ = start_vector(mass_.size());
    now_ /= std::sqrt(now_.dot(mass_.cwiseProduct(now_)));
    before_ = VectorXd::Zero(mass_.size());
    next_ = before_;
    alpha_.clear();
    beta_.clear();
  }
  void advance() {
    apply(blocks_, mass_, now_, next_);
    alpha_.push_back(next_.dot(mass_.cwiseProduct(now_)));
    next_ -= alpha_.back() * now_;
    if (!beta_.empty()) { next_ -= beta_.back() * before_; }
    beta_.push_back(std::sqrt(next_.dot(mass_.cwiseProduct(next_))));
    before_.swap(now_);
    now_ = beta_.back() > 0.0 ? VectorXd(next_ / beta_.back()) : next_;
  }

  const std::vector<Block>& blocks_;
  const VectorXd& mass_;
  VectorXd before_, now_, next_;
  std::vector<double> alpha_, beta_;  ///< diagonal of the tridiagonal matrix, and beside it
  VectorXd ritz_;
};

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

/// Free nodes of a network whose modes are still sought as a whole; of a larger one this many around the node
/// that looks fastest.
constexpr Eigen::Index most_nodes = 8000;

Part whole_or_part(const NetworkProblem& problem, Eigen::Index fastest) {
  const auto& free = problem.free_nodes();
  const auto nodes = static_cast<Eigen::Index>(free.size());
  std::vector<Eigen::Index> order(free.size());
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  if (nodes > most_nodes) {
    const NodeVectors& places = problem.network().rest_position;
    const Vector3d middle = places.col(free[static_cast<std::size_t>(fastest)]);
    const auto distance = [&](Eigen::Index i) {  // in the largest norm: cubes suit lattices
      return (places.col(free[static_cast<std::size_t>(i)]) - middle).lpNorm<Eigen::Infinity>();
    };
    std::ranges::nth_element(order, order.begin() + most_nodes, {}, distance);
    order.resize(static_cast<std::size_t>(most_nodes));
    std::ranges::sort(order);
  }
  Part part{.coordinate = std::vector<Eigen::Index>(static_cast<std::size_t>(3 * nodes), -1),
            .mass = VectorXd(3 * static_cast<Eigen::Index>(order.size())),
            .nodes = {}};
  if (!order.empty()) {
    part.nodes = {free[static_cast<std::size_t>(order.front())], free[static_cast<std::size_t>(order.back())]};
  }
  Eigen::Index next = 0;
  for (const Eigen::Index i : order) {
    part.coordinate[static_cast<std::size_t>(3 * i)] = next;
    part.mass.segment<3>(next) = problem.mass().segment<3>(3 * i);
    next += 3;
  }
  return part;
}

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
  const std::vector<Block> blocks = blocks_of(problem, which, part);
  Lanczos lanczos(blocks, part.mass);
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
    const std::vector<Block> blocks = blocks_of(problem, Which::stiffness, part);
    extreme.estimate = Lanczos(blocks, part.mass).largest();
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
