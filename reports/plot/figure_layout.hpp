// SPDX-License-Identifier: MIT
#pragma once
/// Range and ticks of an axis.

#include <functional>
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

// Reduction of long series to the samples that a picture needs. Data files keep all samples.

/// Position of a sample in the picture [px]; not finite if the sample cannot be drawn.
struct Pixel {
  double x = 0.0;
  double y = 0.0;
};
using Projection = std::function<Pixel(double x, double y)>;

/// Returns sample indices in ascending order; every gap (samples that cannot be drawn) is included
/// once. For a curve with increasing x, the first, smallest, largest and last sample of every pixel
/// column are kept, so no spike is lost. Other paths keep samples that move by half a pixel; points
/// keep samples that earlier points do not cover.
std::vector<std::size_t> thinned(const Series& series, const Projection& project);

// Layout of zone labels along the top of the plot: inside their zones if possible, without
// overlap.

/// Zone in pixels from the left edge of the plot.
struct ZoneSpan {
  std::string label{};
  double begin = 0.0;
  double end = 0.0;
};

inline constexpr double zone_font = 11.0;  ///< [px]
inline constexpr double zone_line = 12.0;  ///< width of a line of text [px]

struct ZoneLabel {
  std::string text{};
  double middle = 0.0;      ///< centre in x [px]
  double width = 0.0;       ///< width of the box on the screen [px]
  double height = 0.0;      ///< height downwards from the top of the plot [px]
  double font = zone_font;  ///< [px]
  bool upright = false;     ///< true if rotated to read from bottom to top
};

/// Upper estimate of the width of a text in a sans-serif font of `font` pixels [px].
double text_width(const std::string& text, double font = zone_font);

/// Places labels of at most `tallest` pixels in a plot `width` pixels wide, the widest zone first.
/// Long labels have a smaller font; labels without space are omitted.
std::vector<ZoneLabel> place_zone_labels(std::vector<ZoneSpan> zones, double width, double tallest);

}  // namespace palpate
