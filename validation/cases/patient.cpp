// SPDX-License-Identifier: MIT
#include "validation/cases/groups.hpp"

namespace palpate {

std::vector<Case> patient_cases() { return {}; }

}  // namespace palpate
