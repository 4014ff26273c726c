// SPDX-License-Identifier: MIT
#pragma once
/// The cases of group "stability", by subject. Each function appends its own.

#include <vector>

#include "validation/case.hpp"

namespace palpate::stability {

void add_blow_up_cases(std::vector<Case>& cases);   ///< the step at which a lattice blows up
void add_bound_cases(std::vector<Case>& cases);     ///< guaranteed bounds against exact spectra
void add_map_cases(std::vector<Case>& cases);       ///< growth over step and damping, per scheme
void add_contrast_cases(std::vector<Case>& cases);  ///< stiffness and mass over six decades
void add_abuse_cases(std::vector<Case>& cases);     ///< zero length, inversion, huge forces, NaN
void add_step_cases(std::vector<Case>& cases);      ///< random and zero steps
void add_denormal_cases(std::vector<Case>& cases);  ///< amplitudes below the normal range
void add_drift_cases(std::vector<Case>& cases);     ///< ten million steps without damping

}  // namespace palpate::stability
