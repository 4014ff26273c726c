// SPDX-License-Identifier: MIT
#pragma once
/// Springs that move with the shapes of a far field, and sums over them.

#include <cmath>

#include "model/dynamics/spring_network.hpp"
#include "model/stepping/far_shapes.hpp"

namespace palpate {

/// Sums of k s s^T over many s, some at a time.
class GramSum {
 public:
  explicit GramSum(Eigen::Index size) : rows_(size, together), sum_(Eigen::MatrixXd::Zero(size, size)) {}
  template <class Row>
  void add(const Row& row, double factor) {
    rows_.col(count_++) = std::sqrt(factor) * row;
    if (count_ == rows_.cols()) { flush(); }
  }
  Eigen::MatrixXd take() {
    flush();
    return sum_.selfadjointView<Eigen::Lower>();
  }

 private:
  static constexpr Eigen::Index together = 512;
  void flush() {
    sum_.selfadjointView<Eigen::Lower>().rankUpdate(rows_.leftCols(count_));
    count_ = 0;
  }
  Eigen::MatrixXd rows_;
  Eigen::MatrixXd sum_;
  Eigen::Index count_ = 0;
};

/// visit(spring, u, s) for each spring that moves with the shapes: it grows by s^T z less u . x of its near end, if
/// it has one, u being its direction towards the far one.
template <class Visit>
void visit_far_springs(const SpringNetwork& network, const FarShapes& shapes, Visit visit) {
  Eigen::VectorXd grows(shapes.modes());
  for (const Spring& spring : network.springs) {
    const bool from = shapes.holds(spring.a);
    const bool to = shapes.holds(spring.b);
    if (!from && !to) { continue; }
    Eigen::Vector3d u = (network.rest_position.col(spring.b) - network.rest_position.col(spring.a)).normalized();
    if (to) { grows.noalias() = shapes.of(spring.b) * u; }
    if (from && to) { grows.noalias() -= shapes.of(spring.a) * u; }
    if (from && !to) {
      u = -u;
      grows.noalias() = shapes.of(spring.a) * u;
    }
    visit(spring, u, grows);
  }
}

}  // namespace palpate
