// SPDX-License-Identifier: MIT
#pragma once
/// Range and ticks of an axis.

#include <string>
#include <vector>

#include "validation/outcome.hpp"

namespace palpate {

struct Range {
  double low = 0.0;
  double high = 1.0;
  bool empty = true;  ///< nothing can be drawn
};

Range x_range(const Figure& figure);
Range y_range(const Figure& figure);

/// How far along the axis a value lies, 0 to 1; not finite where the axis has no place for it.
double axis_share(const Axis& axis, const Range& range, double value);

struct Tick {
  double value = 0.0;
  std::string label{};     ///< empty: a minor tick
  std::string exponent{};  ///< raised after the label, "10" and "−3"; empty: none
};

/// At whole decades, at most about eight; at 1, 2 and 5 if the range is less than two and a half
/// decades, or at equal distances if that gives fewer than three.
std::vector<Tick> logarithmic_ticks(const Range& range);

/// At multiples of 1, 2 or 5 times a power of ten, with at most `most` intervals; labels have as
/// many digits as the distance of ticks requires. The range may run downwards, but not be empty.
std::vector<Tick> linear_ticks(const Range& range, int most);

/// The range, or one around it if it is so narrow that its ticks could not be told apart.
Range with_extent(Range range);

/// Widens the ends of a linear axis that have no limit to the next tick.
Range out_to_ticks(const Axis& axis, Range range);

// Axes in the prefix that people would choose: "displacement (mm)" up to 0.9, not "(m)" up to
// 0.0009.

/// A copy whose linear axes in metres, seconds, newtons, pascals, joules, metres per second or
/// watts are scaled where their numbers would have many zeros. Data files keep SI.
Figure in_field_units(Figure figure);

}  // namespace palpate
