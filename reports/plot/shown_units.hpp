// SPDX-License-Identifier: MIT
#pragma once
/// Factors from SI to the units that clinicians and haptics people read.

namespace palpate {

inline constexpr double mm = 1e3;  ///< [mm/m]
inline constexpr double mj = 1e3;  ///< [mJ/J]
inline constexpr double us = 1e6;  ///< [us/s]

}  // namespace palpate
