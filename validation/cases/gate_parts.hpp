// SPDX-License-Identifier: MIT
#pragma once
/// The cases of group "gate": the harness judged by itself.

#include "validation/case.hpp"

namespace palpate::gating {

Case self_case();    ///< the same code never falls
Case faults_case();  ///< planted damage always does

}  // namespace palpate::gating
