// SPDX-License-Identifier: MIT
#pragma once
/// References by the GNU Scientific Library: nothing in common with the other solvers but the
/// first-order form. Errors are controlled per coordinate. Restarted at every break.

#include <Eigen/Core>

#include "reference/solution.hpp"

namespace palpate::reference {

/// Most states (2 x dof) for which the dense Jacobian of solve_gsl_msbdf is accepted.
inline constexpr Eigen::Index dense_state_limit = 600;

/// Explicit Runge-Kutta Prince-Dormand 8(9).
Solution solve_gsl_rk8pd(const Problem& problem, const std::vector<double>& times,
                         const Tolerance& tolerance);

/// Multistep BDF in Nordsieck form with the dense analytic Jacobian; SolverError above the limit.
Solution solve_gsl_msbdf(const Problem& problem, const std::vector<double>& times,
                         const Tolerance& tolerance);

}  // namespace palpate::reference
