// SPDX-License-Identifier: MIT
#pragma once
/// One-step references (ARKODE). Restarted at every break. Tables: runge_kutta_table.hpp; each run asks
/// ARKODE which one it used and refuses one that would reuse a stale stage.

#include "reference/solution.hpp"

namespace palpate::reference {

/// Fehlberg's explicit pair of orders 7 and 8: the first choice when the network is not stiff.
Solution solve_arkode_explicit(const Problem& problem, const std::vector<double>& times,
                               const Tolerance& tolerance);

/// Dormand and Prince's explicit pair of orders 5 and 4: for low accuracy, where it is cheaper.
Solution solve_arkode_dormand_prince(const Problem& problem, const std::vector<double>& times,
                                     const Tolerance& tolerance);

/// Stiffly accurate ESDIRK 5(4) with seven stages, Newton with the analytic Jacobian and KLU: the
/// first choice for stiff damping or strong contrasts of stiffness.
Solution solve_arkode_esdirk(const Problem& problem, const std::vector<double>& times,
                             const Tolerance& tolerance);

}  // namespace palpate::reference
