// SPDX-License-Identifier: MIT
#pragma once
/// Words of gnuplot's language. Colours are stand-ins that gnuplot_svg.hpp exchanges for classes of
/// the page.

#include <string>

#include "reports/plot/axis_range.hpp"
#include "reports/plot/figure_look.hpp"
#include "validation/outcome.hpp"

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

// Zones and marks of a figure in gnuplot's language. Such figures have margins of their own, so
// that it is known where the plot lies and what room a label has.

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

// A Figure in gnuplot's language.

/// Draws the figure into the file `output`, without title and legend, which are text of the page.
/// Long series are thinned to what the picture can show (thinning.hpp).
std::string gnuplot_script(const Figure& in_si, const std::string& output);

}  // namespace palpate
