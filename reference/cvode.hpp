// SPDX-License-Identifier: MIT
#pragma once
/// Linear multistep references of variable order and step (CVODE). Restarted at every break.

#include "reference/solution.hpp"

namespace palpate::reference {

/// Adams-Moulton up to order 12, fixed-point iteration: for problems that are not stiff.
Solution solve_cvode_adams(const Problem& problem, const std::vector<double>& times,
                           const Tolerance& tolerance);

/// Backward differentiation up to order 5, Newton with the analytic Jacobian and KLU.
Solution solve_cvode_bdf(const Problem& problem, const std::vector<double>& times,
                         const Tolerance& tolerance);

}  // namespace palpate::reference
