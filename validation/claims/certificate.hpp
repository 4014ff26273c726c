// SPDX-License-Identifier: MIT
#pragma once
/// What the group "certificate" is made of besides its own file.

#include <cstdint>
#include <vector>

#include "validation/case.hpp"
#include "validation/certificate/tail.hpp"

namespace palpate::certificate {

std::vector<Case> tail_cases();  ///< what is extrapolated, and what is refused

/// Judged of responses of which every late one makes the next one late.
Tail tail_of_pairs(std::uint64_t seed);

}  // namespace palpate::certificate
