// SPDX-License-Identifier: MIT
#pragma once
/// Change of one quantity or curve between accepted and new results.

#include <string>
#include <string_view>
#include <vector>

#include "validation/outcome.hpp"

namespace palpate::gate {

/// Ordered: the later, the worse. "worse" and what follows fail.
enum class ChangeKind {
  same,      ///< equal to the last bit
  rounding,  ///< the difference is within the measured effect of rounding
  within,    ///< the difference is within what is allowed
  better,    ///< an error or a cost became smaller
  worse,     ///< an error or a cost became larger
  moved,     ///< by more than is allowed, without a direction that is better
  broken     ///< cannot be compared: missing, not finite, of another unit, judged by another bound
};
std::string_view name_of(ChangeKind kind);

struct Change {
  std::string item{};  ///< name of a quantity or a curve; empty: the case itself
  ChangeKind kind = ChangeKind::same;
  double before = 0.0;
  double now = 0.0;
  std::string unit{};
  std::string moved{};    ///< "0.31 digits worse", or what cannot be compared
  std::string allowed{};  ///< "0.1 digits"

  [[nodiscard]] bool fails() const { return kind >= ChangeKind::worse; }
};

// Limits of what may change (docs/gate.md).

/// Decimal digits that errors, and all quantities with a better direction, may lose.
inline constexpr double allowed_digits = 0.1;
/// Share by which counts of work, and numbers without a bound, may change.
inline constexpr double allowed_share = 0.01;
/// Share of a two-sided bound's half width below which the distance from its middle is ignored.
inline constexpr double least_offset = 0.01;
/// Factor on the measured spread of rounding, which varies by a decade from build to build.
inline constexpr double spread_margin = 10.0;

/// `spread`: measured effect of rounding [unit of the quantity].
Change compare_quantity(const Quantity& before, const Quantity& now, double spread);

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

/// Largest distance of two curves: of a point of one from the range of the other within the tube's
/// half width in x.
struct Excess {
  double y = 0.0;  ///< beyond the other's range there; 0: within it
  double x = 0.0;  ///< where
};

/// Largest excess of a point of either over the other; x of both rises, neither is empty, all is
/// finite. What lies beyond the end of a curve by more than tube.x is infinitely far from it.
Excess largest_excess(const Path& before, const Path& now, double half_width_x);

// A curve may not leave the tube around the accepted one, nor be early or late (docs/gate.md).

/// Half widths of the tube as shares of the ranges. In x one sample of a second at 1 kHz: an event
/// may come a tick earlier by rounding. In y a fifth of what one per cent of stiffness moves.
inline constexpr double tube_x = 1e-3;
inline constexpr double tube_y = 2e-3;
/// A curve in a figure of larger ones has at least such a share of their range as its own.
inline constexpr double least_range = 0.01;
/// On a logarithmic axis [decimal digits], as for errors.
inline constexpr double tube_digits = 0.1;
/// Share of a sample by which a whole curve may be late, if it has enough samples to measure it.
inline constexpr double allowed_lag = 0.5;
inline constexpr std::size_t least_samples_for_lag = 100;

/// In the coordinates of the axes: decimal logarithms on a logarithmic one.
Tube tube_around(const Figure& figure, std::size_t series);

/// Two figures' series of the same place and label; `spread` is the measured effect of rounding on
/// y.
Change compare_curve(const Figure& before, const Figure& now, std::size_t series, double spread);

/// Number of samples by which `now` is late, from a least-squares fit of the difference by a lag, a
/// gain and an offset. NaN if the curve does not determine it, or if the lag explains less than
/// half of the difference.
double lag_in_samples(const std::vector<double>& x, const std::vector<double>& before,
                      const std::vector<double>& now);

}  // namespace palpate::gate
