// SPDX-License-Identifier: MIT
#pragma once
/// Path data in few bytes: relative moves in tenths of a pixel.

#include <string>
#include <string_view>

#include "reports/figure_look.hpp"

namespace palpate {

/// "12.3", "-.5", "0": to a tenth.
std::string svg_number(double value);

/// Attributes of a path of markers: class and, where a line cap draws them, stroke width.
std::string marker_attributes(Shape shape, const std::string& colour_class, double r);

class SvgPath {
 public:
  void move(double x, double y);
  void line(double x, double y);
  void close() { data_ += 'z'; }
  /// Appends "M.. L.. Z" of gnuplot, or the corners of a polygon ("x,y x,y ...").
  void append(std::string_view absolute);
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
