// SPDX-License-Identifier: MIT
#pragma once
/// Zones and marks of a figure in gnuplot's language. Such figures have margins of their own, so
/// that it is known where the plot lies and what room a label has.

#include <string>

#include "reports/axis_range.hpp"
#include "validation/outcome.hpp"

namespace palpate {

[[nodiscard]] bool is_annotated(const Figure& figure);

/// Of the whole picture [px].
int annotated_height(const Figure& figure);

/// The y axis with room for the labels of zones above the curves; as it is where the axis is
/// logarithmic or has a maximum.
Range range_below_labels(const Figure& figure, const Range& x, const Range& y);

/// Margins, tints, lines, signs and labels. `figure` is in the units of its axes; ranges are not
/// empty.
std::string annotation_commands(const Figure& figure, const Range& x);

/// Distinct labels of marks in order; the sign of a mark is shape_of_mark() of its place here.
std::vector<std::string> mark_labels(const Figure& figure);

}  // namespace palpate
