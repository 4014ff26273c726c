// SPDX-License-Identifier: MIT
#pragma once
/// When a number that moved is worse (docs/gate.md).

#include "validation/gate/change.hpp"
#include "validation/outcome.hpp"

namespace palpate::gate {

/// Errors and everything that a bound tells a good side of may lose so many decimal digits.
inline constexpr double allowed_digits = 0.1;
/// Counts of work, and numbers that no bound judges, may move by such a share.
inline constexpr double allowed_share = 0.01;
/// Below this share of a two-sided bound's half width, being off its middle says nothing.
inline constexpr double least_offset = 0.01;
/// Rounding is given so many times the spread that a few runs showed: it varies by a decade from build to build.
inline constexpr double spread_margin = 10.0;

/// `spread`: what rounding was seen to move it by [unit of the quantity].
Change judge_quantity(const Quantity& before, const Quantity& now, double spread);

}  // namespace palpate::gate
