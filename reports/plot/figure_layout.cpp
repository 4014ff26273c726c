// SPDX-License-Identifier: MIT

#include "reports/plot/figure_layout.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <string_view>
#include <utility>

#include "reports/html/html_page.hpp"

namespace palpate {
namespace {

void include(Range& range, const Axis& axis, const std::vector<double>& values) {
  for (const double value : values) {
    if (!std::isfinite(value) || (axis.logarithmic && value <= 0.0)) { continue; }
    range.low = range.empty ? value : std::min(range.low, value);
    range.high = range.empty ? value : std::max(range.high, value);
    range.empty = false;
  }
}

/// Cells of a heat map reach half a cell beyond their centres.
Range range_of_cells(const Axis& axis, const std::vector<double>& centres) {
  Range range;
  include(range, axis, centres);
  if (centres.size() < 2 || axis.logarithmic) { return range; }
  const double half = 0.5 * std::abs(centres[1] - centres[0]);
  return {range.low - half, range.high + half, range.empty};
}

Range finish(Range range, const Axis& axis, bool tight) {
  if (!range.empty && axis.logarithmic && !tight) {
    const double pad = std::max(0.04 * std::log10(range.high / range.low), 0.05);
    range.low *= std::pow(10.0, -pad);
    range.high *= std::pow(10.0, pad);
  }
  if (tight) {  // a limit of the axis would cut cells in half, but limits may reverse the axis
    if (axis.minimum.value_or(0.0) > axis.maximum.value_or(unbounded)) {
      std::swap(range.low, range.high);
    }
    return range;
  }
  if (axis.minimum) { range.low = *axis.minimum; }
  if (axis.maximum) { range.high = *axis.maximum; }
  return range;
}

std::string minus_sign(const std::string& number) {
  return number.starts_with('-') ? "−" + number.substr(1) : number;
}

Tick power_of_ten(double value, int exponent) {
  return {value, "10", minus_sign(std::to_string(exponent))};
}

Tick plain_tick(double mantissa, int exponent) {
  const double value = mantissa * std::pow(10.0, exponent);
  if (exponent >= -3 && exponent <= 3) { return {value, plain_number(value), {}}; }
  Tick tick = power_of_ten(value, exponent);
  if (mantissa != 1.0) { tick.label = plain_number(mantissa) + "·10"; }
  return tick;
}

std::string fixed(double value, int decimals) {
  std::array<char, 400> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.*f", std::clamp(decimals, 0, 17), value);
  return minus_sign(buffer.data());
}

/// `step` is the distance of ticks, `largest` the largest number on the axis.
Tick labelled(double value, double step, double largest) {
  const auto exponent_of_step = static_cast<int>(std::floor(std::log10(step) + 1e-9));
  if (value == 0.0) { return {0.0, "0", {}}; }
  if (step > 0.99e-4 && largest < 1e6) { return {value, fixed(value, -exponent_of_step), {}}; }
  const auto exponent = static_cast<int>(std::floor(std::log10(std::abs(value)) + 1e-9));
  Tick tick = power_of_ten(value, exponent);
  const double mantissa = value / std::pow(10.0, exponent);
  if (std::abs(mantissa - 1.0) > 1e-9) {
    tick.label = fixed(mantissa, exponent - exponent_of_step) + "·10";
  }
  return tick;
}

double tick_step(const Range& range, int most) {
  const double rough = std::abs(range.high - range.low) / most * (1.0 - 1e-9);
  const double decade = std::pow(10.0, std::floor(std::log10(rough)));
  const double multiple = rough / decade;
  return decade * (multiple <= 1.0 ? 1.0 : multiple <= 2.0 ? 2.0 : multiple <= 5.0 ? 5.0 : 10.0);
}

std::vector<Tick> decade_ticks(const Range& range, int first, int last) {
  const int step = std::max(1, (last - first + 7) / 8);
  std::vector<Tick> ticks;
  for (int exponent = first - 1; exponent <= last; ++exponent) {
    const double decade = std::pow(10.0, exponent);
    const bool labelled = (exponent - first) % step == 0;
    if (decade >= range.low && decade <= range.high) {
      ticks.push_back(labelled ? power_of_ten(decade, exponent) : Tick{.value = decade});
    }
    if (last - first > 6) { continue; }
    for (int n = 2; n < 10; ++n) {
      if (n * decade >= range.low && n * decade <= range.high) {
        ticks.push_back({.value = n * decade});
      }
    }
  }
  return ticks;
}

struct Prefix {
  double from;  ///< smallest maximum value for this prefix
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

/// Unit "(m)" at the end of a label as a view of "m"; empty if it is not one of the units.
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
  // Times above one second keep the unit s.
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

bool is_gap(const Pixel& at) { return !std::isfinite(at.x) || !std::isfinite(at.y); }

/// First, lowest, highest and last sample of every pixel column, for a curve or a filled series.
std::vector<std::size_t> envelope(const Series& series, std::size_t count,
                                  const Projection& project) {
  std::vector<std::size_t> kept;
  std::array<std::size_t, 4> picks{};
  double column = 0.0, lowest = 0.0, highest = 0.0;
  bool open = false;
  bool gap = false;
  const auto close = [&] {
    if (!open) { return; }
    std::ranges::sort(picks);
    const auto last = std::ranges::unique(picks).begin();
    kept.insert(kept.end(), picks.begin(), last);
    open = false;
  };
  for (std::size_t n = 0; n < count; ++n) {
    const Pixel low = project(series.x[n], series.y[n]);
    const Pixel high = series.filled() ? project(series.x[n], series.y2[n]) : low;
    if (is_gap(low) || is_gap(high)) {
      close();
      if (!gap) { kept.push_back(n); }
      gap = true;
      continue;
    }
    gap = false;
    if (!open || std::floor(low.x) != column) {
      close();
      open = true;
      column = std::floor(low.x);
      picks = {n, n, n, n};
      lowest = low.y;
      highest = high.y;
    }
    if (low.y < lowest) { lowest = low.y, picks[1] = n; }
    if (high.y > highest) { highest = high.y, picks[2] = n; }
    picks[3] = n;
  }
  close();
  return kept;
}

/// Samples of a path that move by half a pixel.
std::vector<std::size_t> moving(const Series& series, std::size_t count,
                                const Projection& project) {
  std::vector<std::size_t> kept;
  Pixel last{std::nan(""), std::nan("")};
  for (std::size_t n = 0; n < count; ++n) {
    const Pixel at = project(series.x[n], series.y[n]);
    const bool again = is_gap(at) ? n > 0 && is_gap(last)
                                  : n + 1 < count && std::hypot(at.x - last.x, at.y - last.y) < 0.5;
    if (again) { continue; }
    kept.push_back(n);
    last = at;
  }
  return kept;
}

}  // namespace

Range x_range(const Figure& figure) {
  Range range;
  for (const Series& series : figure.series) { include(range, figure.x, series.x); }
  return finish(figure.heat_map ? range_of_cells(figure.x, figure.heat_map->x) : range, figure.x,
                figure.heat_map.has_value());
}

Range y_range(const Figure& figure) {
  Range range;
  for (const Series& series : figure.series) {
    include(range, figure.y, series.y);
    include(range, figure.y, series.y2);
  }
  return finish(figure.heat_map ? range_of_cells(figure.y, figure.heat_map->y) : range, figure.y,
                figure.heat_map.has_value());
}

double axis_share(const Axis& axis, const Range& range, double value) {
  // Both ranges may be reversed.
  const double span = axis.logarithmic ? std::log(range.high / range.low) : range.high - range.low;
  const double along = axis.logarithmic ? std::log(value / range.low) : value - range.low;
  return span == 0.0 ? 0.5 + 0.0 * along : along / span;
}

std::vector<Tick> logarithmic_ticks(const Range& range) {
  const auto first = static_cast<int>(std::ceil(std::log10(range.low) - 1e-9));
  const auto last = static_cast<int>(std::floor(std::log10(range.high) + 1e-9));
  if (std::log10(range.high / range.low) > 2.5) { return decade_ticks(range, first, last); }
  std::vector<Tick> ticks;
  for (int exponent = first - 1; exponent <= last; ++exponent) {
    for (const double mantissa : std::array{1.0, 2.0, 5.0}) {
      const Tick tick = plain_tick(mantissa, exponent);
      if (tick.value >= range.low && tick.value <= range.high) { ticks.push_back(tick); }
    }
  }
  return ticks.size() >= 3 ? ticks : linear_ticks(range, 5);
}

std::vector<Tick> linear_ticks(const Range& range, int most) {
  const double low = std::min(range.low, range.high);
  const double high = std::max(range.low, range.high);
  const double step = tick_step(range, most);
  const double largest = std::max(std::abs(low), std::abs(high));
  std::vector<Tick> ticks;
  const double slack = 1e-9 * step;  // prevents the loss of a tick at an end by rounding
  for (double n = std::ceil((low - slack) / step); n * step <= high + slack; ++n) {
    ticks.push_back(labelled(std::clamp(n * step, low, high), step, largest));
  }
  return ticks;
}

Range with_extent(Range range) {
  const double size = std::max(std::abs(range.low), std::abs(range.high));
  if (std::abs(range.high - range.low) > 1e-11 * size) { return range; }
  const double half = size == 0.0 ? 0.5 : 0.1 * size;
  return {range.low - half, range.high + half, range.empty};
}

Range out_to_ticks(const Axis& axis, Range range) {
  if (axis.logarithmic || !(range.low < range.high)) { return range; }
  const double step = tick_step(range, 8);
  if (!axis.minimum) { range.low = step * std::floor(range.low / step + 1e-9); }
  if (!axis.maximum) { range.high = step * std::ceil(range.high / step - 1e-9); }
  return range;
}

Figure in_field_units(Figure figure) {
  Prefix x = prefix_for(figure.x, x_range(figure));
  Prefix y = prefix_for(figure.y, y_range(figure));
  if (figure.square) {  // equal scales stay equal: the larger value selects the prefix
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

std::vector<std::size_t> thinned(const Series& series, const Projection& project) {
  std::size_t count = std::min(series.x.size(), series.y.size());
  if (series.filled()) { count = std::min(count, series.y2.size()); }
  if (series.style != Series::Style::points) {
    const bool rises = std::ranges::is_sorted(series.x);
    return series.filled() || rises ? envelope(series, count, project)
                                    : moving(series, count, project);
  }
  std::vector<std::size_t> kept;
  std::set<std::pair<long, long>> covered;
  for (std::size_t n = 0; n < count; ++n) {
    const Pixel at = project(series.x[n], series.y[n]);
    if (is_gap(at)) { continue; }
    if (covered.emplace(std::lround(at.x), std::lround(at.y)).second) { kept.push_back(n); }
  }
  return kept;
}

double text_width(const std::string& text, double font) {
  double em = 0.0;
  for (const char c : text) {
    if ((static_cast<unsigned char>(c) & 0xC0U) == 0x80U) { continue; }  // within a character
    const bool narrow = std::string_view("iljtfr.,:;'!|()[] ").find(c) != std::string_view::npos;
    const bool wide = std::string_view("mwMW").find(c) != std::string_view::npos;
    em += narrow ? 0.34 : wide ? 0.88 : c >= 'A' && c <= 'Z' ? 0.70 : 0.58;
  }
  return font * em;
}

std::vector<ZoneLabel> place_zone_labels(std::vector<ZoneSpan> zones, double width,
                                         double tallest) {
  constexpr double gap = 1.0;       // between a label and the border of its zone or another label
  constexpr double overhang = 8.0;  // beyond the right edge, into the empty margin
  constexpr double smallest_font = 6.0;
  std::vector<ZoneLabel> placed;
  std::ranges::stable_sort(zones, std::ranges::greater{},
                           [](const ZoneSpan& zone) { return zone.end - zone.begin; });
  for (const ZoneSpan& zone : zones) {
    const double length = text_width(zone.label);
    ZoneLabel label{zone.label, 0.5 * (zone.begin + zone.end), length, zone_line};
    label.upright = length > zone.end - zone.begin - 2.0 * gap;
    if (label.upright) {
      label.font = zone_font * std::min(1.0, tallest / length);
      label.width = zone_line;
      label.height = std::min(length, tallest);
      label.middle = std::clamp(label.middle, 0.5 * zone_line, width + overhang - 0.5 * zone_line);
    }
    const bool covers = std::ranges::any_of(placed, [&](const ZoneLabel& other) {
      return std::abs(label.middle - other.middle) < 0.5 * (label.width + other.width) + gap;
    });
    const bool fits = !label.text.empty() && label.font >= smallest_font;
    if (fits && !covers) { placed.push_back(std::move(label)); }
  }
  return placed;
}

}  // namespace palpate
