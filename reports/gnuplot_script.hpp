// SPDX-License-Identifier: MIT
#pragma once
/// A Figure in gnuplot's language. Colours are stand-ins that gnuplot_svg.hpp exchanges for classes
/// of the page.

#include <string>

#include "validation/outcome.hpp"

namespace palpate {

/// "rgb(1,2,n)" stands for a colour of the page.
struct StandIn {
  static constexpr int red = 1;
  static constexpr int green = 2;
  static constexpr int ink = 1;
  static constexpr int grid = 2;
  static constexpr int paper = 3;
  static constexpr int first_series = 16;
};

/// Draws the figure into the file `output`, without title and legend, which are text of the page.
/// Long series are thinned to what the picture can show (thinning.hpp).
std::string gnuplot_script(const Figure& in_si, const std::string& output);

}  // namespace palpate
