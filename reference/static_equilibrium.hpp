// SPDX-License-Identifier: MIT
#pragma once
/// Where a problem comes to rest: f(t, q, 0) = 0.

#include <Eigen/Core>

#include "reference/solution.hpp"

namespace palpate::reference {

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
