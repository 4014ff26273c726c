// SPDX-License-Identifier: MIT
#include "validation/cases/groups.hpp"

namespace palpate {

std::vector<Case> errata_cases() { return {}; }

}  // namespace palpate
