// SPDX-License-Identifier: MIT

#include "reports/plot/figure_look.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <string_view>

namespace palpate {

namespace {

using Style = Series::Style;

bool is_marked(Style style) { return style == Style::points || style == Style::line_and_points; }

/// Returns true if points and dashed lines alternate in the whole figure.
bool comes_in_pairs(const std::vector<Series>& series) {
  if (series.size() < 2 || series.size() % 2 != 0) { return false; }
  for (std::size_t n = 0; n < series.size(); n += 2) {
    if (!is_marked(series[n].style) || series[n + 1].style != Style::dashed) { return false; }
  }
  return true;
}

}  // namespace

std::vector<Look> looks_of(const Figure& figure) {
  const bool pairs = comes_in_pairs(figure.series);
  const bool stacked = std::ranges::any_of(
      figure.series, [](const Series& series) { return series.style == Style::area; });
  std::vector<Look> looks;
  for (std::size_t n = 0; n < figure.series.size(); ++n) {
    const Style style = figure.series[n].style;
    const auto turn = static_cast<int>(pairs ? n / 2 : n);
    Look look{.colour = turn % series_colours, .shape = static_cast<Shape>(turn % shape_count)};
    // Text colour first, then the colours that neither palette contains.
    if (figure.heat_map) { look.colour = turn == 0 ? ink_colour : (turn + 2) % series_colours; }
    look.line = style != Style::points && !figure.series[n].filled();
    if (stacked && !figure.series[n].filled()) { look.colour = ink_colour; }
    look.points = is_marked(style);
    look.opacity = style == Style::band ? 0.22 : style == Style::area ? 0.5 : 0.0;
    look.dash = style == Style::dashed ? 1 : turn >= series_colours ? 2 : 0;
    looks.push_back(look);
  }
  return looks;
}

Shape shape_of_mark(std::size_t kind) { return static_cast<Shape>(kind % shape_count); }

std::string without_unit_one(const std::string& label) {
  constexpr std::string_view one = " (1)";
  return label.ends_with(one) ? label.substr(0, label.size() - one.size()) : label;
}

namespace {

std::string tenths_text(long tenths) {
  std::string text = tenths < 0 ? "-" : "";
  const long size = std::labs(tenths);
  if (size >= 10 || size == 0) { text += std::to_string(size / 10); }
  if (size % 10 != 0) { text += "." + std::to_string(size % 10); }
  return text;
}

long tenths_of(double value) { return std::lround(10.0 * value); }

/// Writes a number after another; a minus sign replaces the separating space.
std::string pair_text(long x, long y) {
  const std::string second = tenths_text(y);
  return tenths_text(x) + (second[0] == '-' ? "" : " ") + second;
}

}  // namespace

std::string svg_number(double value) { return tenths_text(tenths_of(value)); }

std::string marker_attributes(Shape shape, const std::string& colour_class, double r) {
  const std::string width = "\" stroke-width=\"" + svg_number(2.0 * r) + "\"";
  switch (shape) {
    case Shape::disc: return "class=\"l c " + colour_class + width;
    case Shape::square: return "class=\"l q " + colour_class + width;
    case Shape::triangle:
    case Shape::diamond: return "class=\"f " + colour_class + "\"";
    case Shape::open_disc:
    case Shape::open_square: break;
  }
  return "class=\"l " + colour_class + "\"";
}

void SvgPath::move(double x, double y) {
  x_ = tenths_of(x);
  y_ = tenths_of(y);
  data_ += "M" + pair_text(x_, y_);
}

void SvgPath::line(double x, double y) { step(tenths_of(x), tenths_of(y)); }

void SvgPath::step(long x, long y) {
  if (x == x_ && y == y_) { return; }
  if (y == y_) {
    data_ += "h" + tenths_text(x - x_);
  } else if (x == x_) {
    data_ += "v" + tenths_text(y - y_);
  } else {
    data_ += "l" + pair_text(x - x_, y - y_);
  }
  x_ = x;
  y_ = y;
}

void SvgPath::marker(Shape shape, double x, double y, double r) {
  const std::string at = "M" + pair_text(tenths_of(x), tenths_of(y));
  const std::string d = svg_number(2.0 * r);
  const auto from = [&](double dx, double dy) {
    return "M" + pair_text(tenths_of(x + dx), tenths_of(y + dy));
  };
  const auto by = [](double dx, double dy) { return pair_text(tenths_of(dx), tenths_of(dy)); };
  switch (shape) {
    case Shape::disc:
    case Shape::square: data_ += at + "h0"; return;
    case Shape::triangle:
      data_ += from(0.0, -1.3 * r) + "l" + by(-1.3 * r, 2.1 * r) + "h" + svg_number(2.6 * r) + "z";
      return;
    case Shape::diamond: {
      const double c = 1.4 * r;
      data_ += from(0.0, -c) + "l" + by(c, c) + "l" + by(-c, c) + "l" + by(-c, -c) + "z";
      return;
    }
    case Shape::open_disc: {
      const std::string radius = svg_number(r);
      data_ += from(-r, 0.0) + "a" + radius + " " + radius + " 0 1 0 " + d + " 0a" + radius + " " +
               radius + " 0 1 0-" + d + " 0";
      return;
    }
    case Shape::open_square: data_ += from(-r, -r) + "h" + d + "v" + d + "h-" + d + "z"; return;
  }
}

}  // namespace palpate
