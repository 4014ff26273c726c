// SPDX-License-Identifier: MIT
#pragma once

namespace palpate {

/// One millimetre of mercury, as the conventional unit is defined [Pa] (NIST SP 811, appendix B.8).
inline constexpr double pascals_per_mmhg = 133.322387415;

}  // namespace palpate
