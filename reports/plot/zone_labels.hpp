// SPDX-License-Identifier: MIT
#pragma once
/// Where the labels of zones go: along the top of the plot, each within its own zone if it can be,
/// and never over another one.

#include <string>
#include <vector>

namespace palpate {

/// A zone in pixels from the left edge of the plot.
struct ZoneSpan {
  std::string label{};
  double begin = 0.0;
  double end = 0.0;
};

struct ZoneLabel {
  std::vector<std::string> lines{};  ///< one or two
  double middle = 0.0;               ///< across [px]
  double width = 0.0;                ///< of its box on the screen [px]
  double height = 0.0;               ///< from the top of the plot downwards [px]
  bool upright = false;              ///< turned to read from below
};

inline constexpr double zone_font = 11.0;  ///< [px]
inline constexpr double zone_line = 12.0;  ///< from one line to the next [px]

/// Estimated width of a text in a sans-serif face of `font` pixels [px]; rather too large.
double text_width(const std::string& text, double font = zone_font);

/// Labels of at most `tallest` pixels in a plot `width` wide. What is too long is cut to "liga…";
/// a label that finds no room beside the others is left out.
std::vector<ZoneLabel> place_zone_labels(const std::vector<ZoneSpan>& zones, double width,
                                         double tallest);

}  // namespace palpate
