// SPDX-License-Identifier: MIT
#pragma once
/// How the series of a figure look, the same in the picture and in its legend.

#include <string>
#include <string_view>
#include <vector>

#include "validation/outcome.hpp"

namespace palpate {

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
  double opacity = 0.0;  ///< of what is filled; 0: nothing is
  int dash = 0;          ///< 0 solid, 1 dashed, 2 dots and dashes: the colours come round again
};

/// One per series. Where points and dashed lines alternate through the whole figure, each dashed
/// line takes the colour of the points before it. On a heat map the first series is drawn in ink,
/// and so are the lines over stacked areas.
std::vector<Look> looks_of(const Figure& figure);

/// Sign of the n-th kind of mark; after six the shapes come round again.
Shape shape_of_mark(std::size_t kind);

/// An axis label or column title as people read it: without the unit of pure numbers, " (1)".
std::string without_unit_one(const std::string& label);

// Path data in few bytes: relative moves in tenths of a pixel.

/// "12.3", "-.5", "0": to a tenth.
std::string svg_number(double value);

/// Attributes of a path of markers: class and, where a line cap draws them, stroke width.
std::string marker_attributes(Shape shape, const std::string& colour_class, double r);

class SvgPath {
 public:
  void move(double x, double y);
  void line(double x, double y);
  void close() { data_ += 'z'; }
  /// A marker of radius r, for a path with marker_attributes().
  void marker(Shape shape, double x, double y, double r);
  [[nodiscard]] const std::string& data() const { return data_; }
  [[nodiscard]] bool empty() const { return data_.empty(); }

 private:
  void step(long x, long y);

  std::string data_{};
  long x_ = 0, y_ = 0;  // tenths, where the path is
};

}  // namespace palpate
