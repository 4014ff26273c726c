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
  bool empty = true;  ///< true if nothing can be drawn
};

Range x_range(const Figure& figure);
Range y_range(const Figure& figure);

/// Relative position of a value on the axis, 0 to 1; not finite if the value cannot be shown.
double axis_share(const Axis& axis, const Range& range, double value);

struct Tick {
  double value = 0.0;
  std::string label{};     ///< displayed number; empty: minor tick
  std::string exponent{};  ///< superscript after the label, "10" and "−3"; empty: none
};

/// Ticks of a logarithmic axis: at most about eight, at whole decades. A range below two and a half
/// decades has ticks at 1, 2 and 5, or equidistant ticks if that gives fewer than three.
std::vector<Tick> logarithmic_ticks(const Range& range);

/// Ticks of a linear axis at multiples of 1, 2 or 5 times a power of ten, with at most `most`
/// intervals. Labels have as many digits as the tick distance requires. The range may be reversed
/// but not empty.
std::vector<Tick> linear_ticks(const Range& range, int most);

/// Returns the range, widened if it is too narrow for distinct tick labels.
Range with_extent(Range range);

/// Extends the ends of a linear axis that have no explicit limit to the next tick.
Range out_to_ticks(const Axis& axis, Range range);

// Axes with suitable SI prefixes: "displacement (mm)" up to 0.9, not "(m)" up to 0.0009.

/// Returns a copy in which linear axes in m, s, N, Pa, J, m/s or W are rescaled if their numbers
/// would have many zeros. Data files keep SI units.
Figure in_field_units(Figure figure);

}  // namespace palpate
