// SPDX-License-Identifier: MIT
#pragma once
/// Figures as SVG elements for a page. Colours are classes of report.css, so that figures follow
/// the light or dark theme. Output is deterministic.

#include <string>
#include <vector>

#include "validation/outcome.hpp"

namespace palpate {

/// Returns one <svg> element per figure, in order, without title and legend. Long series are
/// thinned to the resolution of the picture.
std::vector<std::string> draw_figures(const std::vector<const Figure*>& figures);

/// Returns the legend of a figure as an HTML list; empty if there are neither series labels nor
/// marks.
std::string html_legend(const Figure& figure);

// Appearance of the series of a figure, shared by the picture and the legend.

/// Colours of the page (report.css): --series-0 to --series-7, and --ink as number 8.
inline constexpr int series_colours = 8;
inline constexpr int ink_colour = series_colours;

enum class Shape { disc, square, triangle, diamond, open_disc, open_square };
inline constexpr int shape_count = 6;

struct Look {
  int colour = 0;
  Shape shape = Shape::disc;
  bool line = true;
  bool points = false;
  double opacity = 0.0;  ///< opacity of the fill; 0: no fill
  int dash = 0;          ///< 0 solid, 1 dashed, 2 dash-dotted; used when the colours repeat
  double width = 1.7;    ///< of the line [px]
};

/// Appearance of each series. If points and dashed lines alternate in the whole figure, each dashed
/// line has the colour of the points before it. The first series on a heat map and lines over
/// stacked areas have the text colour. Thin lines have the colour of the first series.
std::vector<Look> looks_of(const Figure& figure);

/// Shape for the n-th kind of mark; the six shapes repeat.
Shape shape_of_mark(std::size_t kind);

/// Displayed form of an axis label or column title: without " (1)", the unit of dimensionless
/// numbers.
std::string without_unit_one(const std::string& label);

// Compact SVG path data: relative moves in tenths of a pixel.

/// Number rounded to one decimal: "12.3", "-.5", "0".
std::string svg_number(double value);

/// Attributes of a path of markers: class and, for markers drawn by a line cap, stroke width.
std::string marker_attributes(Shape shape, const std::string& colour_class, double r);

class SvgPath {
 public:
  void move(double x, double y);
  void line(double x, double y);
  void close() { data_ += 'z'; }
  /// Appends a marker of radius r to a path with marker_attributes().
  void marker(Shape shape, double x, double y, double r);
  [[nodiscard]] const std::string& data() const { return data_; }
  [[nodiscard]] bool empty() const { return data_.empty(); }

 private:
  void step(long x, long y);

  std::string data_{};
  long x_ = 0, y_ = 0;  // current position [0.1 px]
};

}  // namespace palpate
