// SPDX-License-Identifier: MIT
#pragma once
/// A Problem as a first-order system for libraries that want one:
///   y = [u; v], u = q - q(0) [m], v [m/s];  y' = [v; f(t, q(0) + u, v) / m].
/// Displacements rather than positions, so that relative tolerances and rounding do not depend on
/// where the origin lies.

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <cstdint>
#include <vector>

#include "model/dynamics/problem.hpp"

namespace palpate::reference {

class FirstOrderSystem {
 public:
  explicit FirstOrderSystem(const Problem& problem);

  [[nodiscard]] const Problem& problem() const { return *problem_; }
  [[nodiscard]] Eigen::Index dof() const { return origin_.size(); }
  [[nodiscard]] Eigen::Index size() const { return 2 * origin_.size(); }
  [[nodiscard]] long evaluations() const { return evaluations_; }
  [[nodiscard]] const Eigen::VectorXd& origin() const { return origin_; }  ///< q(0) [m]

  void set_gate(double gate) { gate_ = gate; }  ///< [s] midpoint of the current segment
  void initial_state(double* y) const;
  /// False when a component is not finite. Solvers must be told: many error tests let NaN pass.
  [[nodiscard]] bool derivative(double t, const double* y, double* dy);

 private:
  const Problem* problem_;
  Eigen::VectorXd origin_;
  Eigen::VectorXd inverse_mass_;
  Eigen::VectorXd position_;
  double gate_ = 0.0;
  long evaluations_ = 0;
};

/// dy'/dy = [0 I; -K/m -C/m], compressed by columns. The pattern is fixed at construction and
/// includes the whole diagonal, so that I - gamma J fits in it.
class FirstOrderJacobian {
 public:
  using Index = std::int64_t;  ///< as in the solver libraries

  explicit FirstOrderJacobian(const FirstOrderSystem& system);
  [[nodiscard]] Index size() const { return static_cast<Index>(column_starts_.size()) - 1; }
  [[nodiscard]] const std::vector<Index>& column_starts() const { return column_starts_; }
  [[nodiscard]] const std::vector<Index>& rows() const { return rows_; }
  [[nodiscard]] const std::vector<double>& values() const { return values_; }
  /// Throws SolverError when the problem's pattern has changed.
  void update(const double* y);

 private:
  void evaluate(const double* y);

  const FirstOrderSystem* system_;
  Eigen::VectorXd inverse_mass_;
  Eigen::SparseMatrix<double> stiffness_;
  Eigen::SparseMatrix<double> damping_;
  std::vector<Index> column_starts_;
  std::vector<Index> rows_;
  std::vector<std::size_t> stiffness_slots_;  ///< where each entry of K goes in values_
  std::vector<std::size_t> damping_slots_;
  std::vector<double> values_;
};

}  // namespace palpate::reference
