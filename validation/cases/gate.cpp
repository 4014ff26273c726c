// SPDX-License-Identifier: MIT
#include "validation/cases/gate_parts.hpp"
#include "validation/cases/groups.hpp"

namespace palpate {

std::vector<Case> gate_cases() { return {gating::self_case(), gating::faults_case()}; }

}  // namespace palpate
