// SPDX-License-Identifier: MIT
#pragma once
/// How a linearised problem gives way to small forces, many of them on one stiffness.

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>

#include "model/problem/problem.hpp"
#include "reference/solution.hpp"

namespace palpate::reference {

/// K^-1 of a stiffness matrix, prepared once. Up to `most_factorised` coordinates it is factorised,
/// with one round of refinement for each answer; beyond, where the factors of a block would take
/// more than a gigabyte, a symmetric one goes through conjugate gradients to a residual of 1e-10,
/// in at most `most_rounds`.
class StaticResponse {
 public:
  /// K of the problem at its rest position. SolverError where K is singular, that is, where the
  /// body can move freely; a large K may show that only when it is asked.
  explicit StaticResponse(const Problem& problem, Eigen::Index most_factorised = 15000,
                          int most_rounds = 20000);
  explicit StaticResponse(Eigen::SparseMatrix<double> stiffness,
                          Eigen::Index most_factorised = 15000, int most_rounds = 20000);
  ~StaticResponse();
  StaticResponse(StaticResponse&&) noexcept;
  StaticResponse& operator=(StaticResponse&&) noexcept;

  /// Displacement K^-1 f [m] under the forces f [N].
  [[nodiscard]] Eigen::VectorXd operator()(const Eigen::VectorXd& force) const;
  /// w.K^-1 w [m/N]: how far the weighted mean w of coordinates gives way to a newton shared by w.
  [[nodiscard]] double compliance(const Eigen::VectorXd& w) const { return w.dot((*this)(w)); }

 private:
  class Solver;
  class Cholesky;
  class Gauss;
  class Gradients;
  std::unique_ptr<Solver> solver_;
};

// Where a problem comes to rest: f(t, q, 0) = 0.

struct Equilibrium {
  Eigen::VectorXd position{};  ///< q [m]
  int iterations = 0;
  double residual = 0.0;  ///< largest |f(q)| over the largest |f(start)|
};

struct EquilibriumOptions {
  double time = 0.0;         ///< [s] at which loads are evaluated
  double gate = 0.0;         ///< [s] which decides what loads are on
  double tolerance = 1e-12;  ///< on the residual; rounding of the spring forces also suffices
  int iteration_limit = 100;
};

/// Newton with step halving from `start` (the initial position by default), sparse LDL^T, or LU
/// where the stiffness is not symmetric and definite. SolverError when it does not converge or when
/// the stiffness is singular (the body can move freely).
Equilibrium static_equilibrium(const Problem& problem, const EquilibriumOptions& options = {});
Equilibrium static_equilibrium(const Problem& problem, const EquilibriumOptions& options,
                               const Eigen::VectorXd& start);

}  // namespace palpate::reference
