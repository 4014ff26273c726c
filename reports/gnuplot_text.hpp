// SPDX-License-Identifier: MIT
#pragma once
/// Words of gnuplot's language. Colours are stand-ins that gnuplot_svg.hpp exchanges for classes of
/// the page.

#include <string>

#include "reports/figure_look.hpp"

namespace palpate {

/// "rgb(1,2,n)" stands for a colour of the page.
struct StandIn {
  static constexpr int red = 1;
  static constexpr int green = 2;
  static constexpr int ink = 1;
  static constexpr int grid = 2;
  static constexpr int paper = 3;
  static constexpr int zone_a = 4;
  static constexpr int zone_b = 5;
  static constexpr int note = 6;  ///< labels of zones, marks
  static constexpr int first_series = 16;
};

inline constexpr int picture_width = 480;  ///< [px]

/// " lc rgb '#010210'", or with "fc" or "tc" for what is filled or written.
std::string colour(int stand_in, const char* what = "lc");

/// In double quotes, with octal codes for all that gnuplot would act on; a line break, which would
/// end the command, becomes a space.
std::string quoted(const std::string& text);

/// gnuplot's marker of a shape.
int point_type(Shape shape);

}  // namespace palpate
