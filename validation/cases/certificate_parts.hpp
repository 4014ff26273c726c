// SPDX-License-Identifier: MIT
#pragma once
/// What the group "certificate" is made of besides its own file.

#include <vector>

#include "validation/case.hpp"

namespace palpate::certificate {

std::vector<Case> tail_cases();  ///< what is extrapolated, and what is refused

}  // namespace palpate::certificate
