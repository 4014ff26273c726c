// SPDX-License-Identifier: MIT
#pragma once
/// Factors from SI units to displayed units.

namespace palpate {

inline constexpr double mm = 1e3;  ///< [mm/m]
inline constexpr double mj = 1e3;  ///< [mJ/J]
inline constexpr double us = 1e6;  ///< [us/s]

}  // namespace palpate
