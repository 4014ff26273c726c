// SPDX-License-Identifier: MIT
#include "reports/field_units.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "reports/axis_range.hpp"

namespace palpate {

namespace {

struct Prefix {
  double from;  ///< least largest number that it is chosen for
  double factor;
  std::string_view symbol;
};
constexpr std::array<Prefix, 6> prefixes{{{1e7, 1e-6, "M"},
                                          {1e4, 1e-3, "k"},
                                          {1e-2, 1.0, ""},
                                          {1e-5, 1e3, "m"},
                                          {1e-8, 1e6, "µ"},
                                          {1e-11, 1e9, "n"}}};
constexpr std::array<std::string_view, 7> units{"m", "s", "N", "Pa", "J", "m/s", "W"};

/// "(m)" at the end of a label, as a view of "m"; empty when it is none of the units.
std::string_view unit_of(const std::string& label) {
  const std::size_t open = label.rfind('(');
  if (open == std::string::npos || label.back() != ')') { return {}; }
  const std::string_view unit = std::string_view(label).substr(open + 1, label.size() - open - 2);
  return std::ranges::find(units, unit) == units.end() ? std::string_view() : unit;
}

Prefix prefix_for(const Axis& axis, const Range& range) {
  const Prefix none{0.0, 1.0, ""};
  if (axis.logarithmic || range.empty || unit_of(axis.label).empty()) { return none; }
  const double largest = std::max(std::abs(range.low), std::abs(range.high));
  // Nobody says kiloseconds.
  const bool large_units =
      std::string_view("N Pa J W").find(unit_of(axis.label)) != std::string_view::npos;
  for (const Prefix& prefix : prefixes) {
    if (largest >= prefix.from) { return prefix.factor < 1.0 && !large_units ? none : prefix; }
  }
  return none;
}

void scale(std::vector<double>& values, double factor) {
  for (double& value : values) { value *= factor; }
}

void scale(Axis& axis, const Prefix& prefix) {
  if (prefix.factor == 1.0) { return; }
  axis.label.insert(axis.label.rfind('(') + 1, prefix.symbol);
  if (axis.minimum) { *axis.minimum *= prefix.factor; }
  if (axis.maximum) { *axis.maximum *= prefix.factor; }
}

}  // namespace

Figure in_field_units(Figure figure) {
  Prefix x = prefix_for(figure.x, x_range(figure));
  Prefix y = prefix_for(figure.y, y_range(figure));
  if (figure.square) {  // equal scales stay equal: the larger number decides
    if (unit_of(figure.x.label) != unit_of(figure.y.label)) { return figure; }
    x = y = x.factor < y.factor ? x : y;
  }
  for (Series& series : figure.series) {
    scale(series.x, x.factor);
    scale(series.y, y.factor);
    scale(series.y2, y.factor);
  }
  for (Zone& zone : figure.zones) {
    zone.begin *= x.factor;
    zone.end *= x.factor;
  }
  for (Mark& mark : figure.marks) { mark.x *= x.factor; }
  if (figure.heat_map) {
    scale(figure.heat_map->x, x.factor);
    scale(figure.heat_map->y, y.factor);
  }
  scale(figure.x, x);
  scale(figure.y, y);
  return figure;
}

}  // namespace palpate
