// SPDX-License-Identifier: MIT
#pragma once
/// What an axis spans, and where a logarithmic one has its ticks.

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
  std::string label{};  ///< gnuplot's enhanced text; empty: a minor tick
};

/// Over less than two and a half decades at 1, 2 and 5, or evenly where that gives too few; else at
/// whole decades, at most about eight.
std::vector<Tick> logarithmic_ticks(const Range& range);

// Axes in the prefix that people would choose: "displacement (mm)" up to 0.9, not "(m)" up to
// 0.0009.

/// A copy whose linear axes in metres, seconds, newtons, pascals, joules, metres per second or
/// watts are scaled where their numbers would have many zeros. Data files keep SI.
Figure in_field_units(Figure figure);

}  // namespace palpate
