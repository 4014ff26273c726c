// SPDX-License-Identifier: MIT
#pragma once
/// Claims about tissue that is built from surfaces and images, of solids and phantoms with known answers.

#include <vector>

#include "validation/case.hpp"

namespace palpate {

std::vector<Case> patient_tissue_cases();

Case skin_case();   ///< "tissue/skin"
Case hertz_case();  ///< "tissue/hertz"

}  // namespace palpate
