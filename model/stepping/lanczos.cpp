// SPDX-License-Identifier: MIT
#include "model/stepping/lanczos.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Eigenvalues>

namespace palpate {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int most_vectors = 200;
constexpr double accuracy = 1e-5;
/// Free nodes of a network whose modes are still sought as a whole; of a larger one this many.
constexpr Eigen::Index most_nodes = 8000;

/// Fixed, with every wave length in it.
VectorXd start_vector(Eigen::Index size) {
  VectorXd x(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    x(i) = std::cos(1.0 + 12.9898 * static_cast<double>(i)) + (i % 2 == 0 ? 0.3 : -0.3);
  }
  return x;
}

}  // namespace

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

Lanczos::Lanczos(const NetworkProblem& problem, spring_blocks::Which which, const Part& part) : mass_(part.mass) {
  const auto in_part = [&](Eigen::Index c) {
    return c < 0 ? c : part.coordinate[static_cast<std::size_t>(c)];
  };
  const auto wanted = [&](Eigen::Index c) { return in_part(c) >= 0; };
  spring_blocks::visit_blocks(problem, which, part.nodes, wanted,
                              [&](Eigen::Index a, Eigen::Index b, const Matrix3d& matrix) {
                                blocks_.push_back({in_part(a), in_part(b), matrix});
                              });
}

double Lanczos::largest() {
  begin();
  double value = 0.0;
  for (int n = 0; n < most_vectors; ++n) {
    advance();
    const bool look = n % 8 == 7 || n + 1 == most_vectors || !(beta_.back() > 0.0);
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
  return value * (1.0 - spring_blocks::roundings);
}

VectorXd Lanczos::vector() {
  begin();
  VectorXd sum = VectorXd::Zero(mass_.size());
  for (const double share : ritz_) {
    sum += share * now_;
    advance();
  }
  return sum;
}

/// y = M^-1 (sum of blocks) x.
void Lanczos::apply(const VectorXd& x, VectorXd& y) const {
  y.setZero();
  for (const Block& block : blocks_) {
    Vector3d difference = Vector3d::Zero();
    if (block.a >= 0) { difference -= x.segment<3>(block.a); }
    if (block.b >= 0) { difference += x.segment<3>(block.b); }
    const Vector3d f = block.matrix * difference;
    if (block.a >= 0) { y.segment<3>(block.a) -= f; }
    if (block.b >= 0) { y.segment<3>(block.b) += f; }
  }
  y.array() /= mass_.array();
}

void Lanczos::begin() {
  now_ = start_vector(mass_.size());
  now_ /= std::sqrt(now_.dot(mass_.cwiseProduct(now_)));
  before_ = VectorXd::Zero(mass_.size());
  next_ = before_;
  alpha_.clear();
  beta_.clear();
}

void Lanczos::advance() {
  apply(now_, next_);
  alpha_.push_back(next_.dot(mass_.cwiseProduct(now_)));
  next_ -= alpha_.back() * now_;
  if (!beta_.empty()) { next_ -= beta_.back() * before_; }
  beta_.push_back(std::sqrt(next_.dot(mass_.cwiseProduct(next_))));
  before_.swap(now_);
  now_ = beta_.back() > 0.0 ? VectorXd(next_ / beta_.back()) : next_;
}

}  // namespace palpate
