// SPDX-License-Identifier: MIT
#include "validation/cases/groups.hpp"

namespace palpate {

std::vector<Case> network_cases() { return {}; }

}  // namespace palpate
