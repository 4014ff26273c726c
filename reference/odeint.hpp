// SPDX-License-Identifier: MIT
#pragma once
/// One-step references (Boost.odeint). Restarted at every break.

#include "reference/solution.hpp"

namespace palpate::reference {

/// Dormand and Prince's explicit pair of orders 5 and 4, with the library's own control of the step.
Solution solve_odeint_dormand_prince(const Problem& problem, const std::vector<double>& times,
                                     const Tolerance& tolerance);

}  // namespace palpate::reference
