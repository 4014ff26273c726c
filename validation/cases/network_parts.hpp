// SPDX-License-Identifier: MIT
#pragma once
/// The cases of group "network", by subject.

#include <vector>

#include "validation/case.hpp"

namespace palpate::networks {

std::vector<Case> elasticity_cases();     ///< the lattice as an elastic solid, at rest
std::vector<Case> wave_cases();           ///< frequencies and dispersion against closed forms
std::vector<Case> skew_cases();           ///< the paper's Fig. 12
std::vector<Case> momentum_cases();       ///< nothing outside, nothing gained
std::vector<Case> energy_cases();         ///< undamped: kept; damped: only lost
std::vector<Case> work_cases();           ///< work of loads = energy change + dissipation
std::vector<Case> invariance_cases();     ///< what must not depend on frame, numbering or unit
std::vector<Case> block_cases();          ///< the paper's Figs. 13-15 against references
std::vector<Case> order_cases();          ///< observed order on a nonlinear lattice
std::vector<Case> load_cases();           ///< which steps a load acts on
std::vector<Case> kernel_cases();         ///< fast kernels equal the specification
std::vector<Case> manufactured_cases();   ///< chosen exact solutions
std::vector<Case> approximation_cases();  ///< heavy nodes, single precision, skipped work

}  // namespace palpate::networks
