// SPDX-License-Identifier: MIT
#include "reports/figure_look.hpp"

#include <algorithm>
#include <string_view>

namespace palpate {

namespace {

using Style = Series::Style;

bool is_marked(Style style) { return style == Style::points || style == Style::line_and_points; }

/// Measured, law, measured, law, ...
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
    // Ink first, then the colours that neither palette contains.
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

}  // namespace palpate
