// SPDX-License-Identifier: MIT
#pragma once
/// When a curve has left the tube around the accepted one, or runs ahead of it or behind (docs/gate.md).

#include "validation/gate/change.hpp"
#include "validation/gate/tube.hpp"
#include "validation/outcome.hpp"

namespace palpate::gate {

/// Half widths of the tube as shares of the ranges. In x one sample of a second at 1 kHz: an event may come a
/// tick earlier by rounding. In y a fifth of what one per cent of stiffness moves.
inline constexpr double tube_x = 1e-3;
inline constexpr double tube_y = 2e-3;
/// A curve in a figure of larger ones has at least such a share of their range as its own.
inline constexpr double least_range = 0.01;
/// On a logarithmic axis [decimal digits], as for errors.
inline constexpr double tube_digits = 0.1;
/// A whole curve may be late by such a share of a sample, where it has so many samples that this can be told.
inline constexpr double allowed_lag = 0.5;
inline constexpr std::size_t least_samples_for_lag = 100;

/// In the coordinates of the axes: decimal logarithms on a logarithmic one.
Tube tube_around(const Figure& figure, std::size_t series);

/// Two figures' series of the same place and label; `spread` is what rounding moves it by, in y.
Change judge_curve(const Figure& before, const Figure& now, std::size_t series, double spread);

/// By how many samples `now` is late, from the least-squares fit of its difference by a lag, a gain and an
/// offset; NaN where the curve does not tell, or where less than half of the difference is a lag.
double lag_in_samples(const std::vector<double>& x, const std::vector<double>& before,
                      const std::vector<double>& now);

}  // namespace palpate::gate
