// SPDX-License-Identifier: MIT
#pragma once
/// The parts of the oscillator group; oscillator.cpp joins them.

#include <vector>

#include "validation/case.hpp"

namespace palpate::oscillator {

std::vector<Case> order_cases();            ///< oscillator/order/<scheme>
std::vector<Case> discrete_cases();         ///< oscillator/discrete/<scheme>
std::vector<Case> stability_limit_cases();  ///< oscillator/stability-limit/<scheme>
std::vector<Case> regime_cases();           ///< oscillator/regimes
std::vector<Case> figure_cases();           ///< oscillator/figure-6 ... figure-9
std::vector<Case> phase_cases();            ///< oscillator/figure-10
std::vector<Case> comparison_cases();       ///< oscillator/who-is-closest
std::vector<Case> sweep_cases();            ///< oscillator/sweep

}  // namespace palpate::oscillator
