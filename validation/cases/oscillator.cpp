// SPDX-License-Identifier: MIT
#include "validation/cases/groups.hpp"

namespace palpate {

std::vector<Case> oscillator_cases() { return {}; }

}  // namespace palpate
