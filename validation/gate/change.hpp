// SPDX-License-Identifier: MIT
#pragma once
/// One thing that a gate looked at, and what it thinks of it.

#include <string>
#include <string_view>
#include <vector>

#include "validation/outcome.hpp"

namespace palpate::gate {

enum class Judgement {
  same,      ///< to the last bit
  rounding,  ///< differs by no more than rounding was seen to
  within,    ///< differs by less than is allowed
  better,    ///< an error shrank, or a cost
  worse,     ///< an error grew, or a cost
  moved,     ///< by more than is allowed; whether for the better cannot be told
  broken     ///< cannot be compared: missing, not finite, of another unit, judged by another bound
};
std::string_view name_of(Judgement judgement);

struct Change {
  std::string item{};  ///< name of a quantity or a curve; empty: the case itself
  Judgement judgement = Judgement::same;
  double before = 0.0;
  double now = 0.0;
  std::string unit{};
  std::string moved{};    ///< "0.31 digits worse", or what is broken
  std::string allowed{};  ///< "0.1 digits"

  [[nodiscard]] bool falls() const {
    return judgement == Judgement::worse || judgement == Judgement::moved ||
           judgement == Judgement::broken;
  }
};

// When a number that moved is worse (docs/gate.md).

/// Errors and everything that a bound tells a good side of may lose so many decimal digits.
inline constexpr double allowed_digits = 0.1;
/// Counts of work, and numbers that no bound judges, may move by such a share.
inline constexpr double allowed_share = 0.01;
/// Below this share of a two-sided bound's half width, being off its middle says nothing.
inline constexpr double least_offset = 0.01;
/// Rounding is given so many times the spread that a few runs showed: it varies by a decade from
/// build to build.
inline constexpr double spread_margin = 10.0;

/// `spread`: what rounding was seen to move it by [unit of the quantity].
Change judge_quantity(const Quantity& before, const Quantity& now, double spread);

// Distance of a curve from a tube around another.

/// A curve over rising x, in the coordinates that are compared.
struct Path {
  std::vector<double> x{};
  std::vector<double> y{};
};

/// Half widths, in the coordinates of the paths.
struct Tube {
  double x = 0.0;
  double y = 0.0;
};

/// Where two curves are furthest apart, by their own reckoning: how far a point of the one lies
/// beyond all that the other does within the tube's half width in x.
struct Excess {
  double y = 0.0;  ///< beyond the other's range there; 0: within it
  double x = 0.0;  ///< where
};

/// Largest excess of a point of either over the other; x of both rises, neither is empty, all is
/// finite. What lies beyond the end of a curve by more than tube.x is infinitely far from it.
Excess largest_excess(const Path& before, const Path& now, double half_width_x);

// When a curve has left the tube around the accepted one, or runs ahead of it or behind
// (docs/gate.md).

/// Half widths of the tube as shares of the ranges. In x one sample of a second at 1 kHz: an event
/// may come a tick earlier by rounding. In y a fifth of what one per cent of stiffness moves.
inline constexpr double tube_x = 1e-3;
inline constexpr double tube_y = 2e-3;
/// A curve in a figure of larger ones has at least such a share of their range as its own.
inline constexpr double least_range = 0.01;
/// On a logarithmic axis [decimal digits], as for errors.
inline constexpr double tube_digits = 0.1;
/// A whole curve may be late by such a share of a sample, where it has so many samples that this
/// can be told.
inline constexpr double allowed_lag = 0.5;
inline constexpr std::size_t least_samples_for_lag = 100;

/// In the coordinates of the axes: decimal logarithms on a logarithmic one.
Tube tube_around(const Figure& figure, std::size_t series);

/// Two figures' series of the same place and label; `spread` is what rounding moves it by, in y.
Change judge_curve(const Figure& before, const Figure& now, std::size_t series, double spread);

/// By how many samples `now` is late, from the least-squares fit of its difference by a lag, a gain
/// and an offset; NaN where the curve does not tell, or where less than half of the difference is a
/// lag.
double lag_in_samples(const std::vector<double>& x, const std::vector<double>& before,
                      const std::vector<double>& now);

}  // namespace palpate::gate
