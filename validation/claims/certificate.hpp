// SPDX-License-Identifier: MIT
#pragma once
/// Parts of the case group "certificate" outside its main file.

#include <cstdint>
#include <vector>

#include "validation/case.hpp"
#include "validation/certificate/tail.hpp"

namespace palpate::certificate {

std::vector<Case> tail_cases();  ///< accepted and refused extrapolations

/// Returns the tail of responses in which every late one makes the next one late.
Tail tail_of_pairs(std::uint64_t seed);

}  // namespace palpate::certificate
