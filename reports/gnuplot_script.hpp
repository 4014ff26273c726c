// SPDX-License-Identifier: MIT
#pragma once
/// A Figure in gnuplot's language.

#include <string>

#include "validation/outcome.hpp"

namespace palpate {

/// Number of distinct series colours; more series repeat them with another dash.
inline constexpr int series_colours = 8;

/// Stand-in colours that draw_figures exchanges for CSS variables: "rgb(1,2,n)".
struct StandIn {
  static std::string ink();
  static std::string grid();
  static std::string series(std::size_t index);
};

/// Draws the figure into `output`. Long lines are thinned to what a picture can show: the extremes
/// of each of 320 columns.
std::string gnuplot_script(const Figure& figure, const std::string& output);

}  // namespace palpate
