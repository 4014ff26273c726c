// SPDX-License-Identifier: MIT
#pragma once
/// Layout of zone labels along the top of the plot: inside their zones if possible, without
/// overlap.

#include <string>
#include <vector>

namespace palpate {

/// Zone in pixels from the left edge of the plot.
struct ZoneSpan {
  std::string label{};
  double begin = 0.0;
  double end = 0.0;
};

struct ZoneLabel {
  std::vector<std::string> lines{};  ///< one or two lines
  double middle = 0.0;               ///< centre in x [px]
  double width = 0.0;                ///< width of the box on the screen [px]
  double height = 0.0;               ///< height downwards from the top of the plot [px]
  bool upright = false;              ///< true if rotated to read from bottom to top
};

inline constexpr double zone_font = 11.0;  ///< [px]
inline constexpr double zone_line = 12.0;  ///< line distance [px]

/// Upper estimate of the width of a text in a sans-serif font of `font` pixels [px].
double text_width(const std::string& text, double font = zone_font);

/// Places labels of at most `tallest` pixels in a plot `width` pixels wide. Long labels are
/// shortened ("liga…"); labels without space are omitted.
std::vector<ZoneLabel> place_zone_labels(const std::vector<ZoneSpan>& zones, double width,
                                         double tallest);

}  // namespace palpate
