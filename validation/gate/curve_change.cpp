// SPDX-License-Identifier: MIT
#include "validation/gate/curve_change.hpp"

#include <algorithm>
#include <cmath>

#include "validation/gate/baseline.hpp"
#include "validation/gate/quantity_change.hpp"
#include "validation/number_words.hpp"

namespace palpate::gate {

namespace {

double coordinate(double value, bool logarithmic) { return logarithmic ? std::log10(std::abs(value)) : value; }

std::vector<double> coordinates(const std::vector<double>& values, bool logarithmic) {
  std::vector<double> list(values);
  for (double& each : list) { each = coordinate(each, logarithmic); }
  return list;
}

double range_of(const std::vector<double>& values) {
  double least = unbounded;
  double greatest = -unbounded;
  for (const double value : values) {
    if (!std::isfinite(value)) { continue; }
    least = std::min(least, value);
    greatest = std::max(greatest, value);
  }
  return greatest > least ? greatest - least : 0.0;
}

/// Of all curves of a figure together.
double range_of_all(const Figure& figure) {
  std::vector<double> all;
  for (const Series& each : figure.series) { all.insert(all.end(), each.y.begin(), each.y.end()); }
  return range_of(coordinates(all, figure.y.logarithmic));
}

/// Sizes and gaps: a value that is not finite may stand only where one stood.
std::string obstacle(const Series& before, const Series& now) {
  if (now.x.size() != now.y.size()) { return "x and y of different lengths"; }
  if (now.label != before.label) { return "is called \"" + now.label + "\", was \"" + before.label + "\""; }
  if (now.y.size() != before.y.size()) {
    return std::to_string(now.y.size()) + " samples, was " + std::to_string(before.y.size());
  }
  for (std::size_t n = 0; n < now.y.size(); ++n) {
    const bool same_y = std::isfinite(now.y[n]) == std::isfinite(before.y[n]);
    const bool same_x = std::isfinite(now.x[n]) == std::isfinite(before.x[n]);
    if (!same_x || !same_y) {
      return "sample " + std::to_string(n) + " is " + plain_number(now.y[n]) + " at " + plain_number(now.x[n]) +
             ", was " + plain_number(before.y[n]);
    }
  }
  return {};
}

bool equal(const std::vector<double>& a, const std::vector<double>& b) {
  return std::ranges::equal(a, b, [](double p, double q) { return p == q || (std::isnan(p) && std::isnan(q)); });
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0.0;
  for (std::size_t n = 0; n < a.size(); ++n) {
    if (std::isfinite(a[n])) { largest = std::max(largest, std::abs(a[n] - b[n])); }
  }
  return largest;
}

/// What can be drawn of a curve, from left to right.
Path path_of(const Series& series, const Figure& figure) {
  Path path;
  for (std::size_t n = 0; n < series.x.size(); ++n) {
    const double x = coordinate(series.x[n], figure.x.logarithmic);
    const double y = coordinate(series.y[n], figure.y.logarithmic);
    if (!std::isfinite(x) || !std::isfinite(y)) { continue; }
    path.x.push_back(x);
    path.y.push_back(y);
  }
  if (!std::ranges::is_sorted(path.x) && std::ranges::is_sorted(path.x, std::ranges::greater{})) {
    std::ranges::reverse(path.x);
    std::ranges::reverse(path.y);
  }
  return path;
}

/// Points, and curves that turn back, sample by sample.
Excess excess_by_sample(const Path& before, const Path& now, double half_width_x) {
  Excess largest;
  for (std::size_t n = 0; n < before.x.size(); ++n) {
    const bool off = n >= now.x.size() || !(std::abs(now.x[n] - before.x[n]) <= half_width_x);
    const double y = off ? unbounded : std::abs(now.y[n] - before.y[n]);
    if (!(y <= largest.y)) { largest = {.y = y, .x = before.x[n]}; }
  }
  return now.x.size() == before.x.size() ? largest : Excess{.y = unbounded, .x = largest.x};
}

Excess excess_of(const Path& before, const Path& now, double half_width_x, Series::Style style) {
  const bool curves = style != Series::Style::points && std::ranges::is_sorted(before.x) &&
                      std::ranges::is_sorted(now.x) && !before.x.empty() && !now.x.empty();
  return curves ? largest_excess(before, now, half_width_x) : excess_by_sample(before, now, half_width_x);
}

void judge_tube(const Figure& before, const Figure& now, std::size_t series, Change& change) {
  const Tube tube = tube_around(before, series);
  const Excess excess = excess_of(path_of(before.series[series], before), path_of(now.series[series], now),
                                  tube.x, before.series[series].style);
  const std::string unit = before.y.logarithmic ? " digits" : "";
  const double x = before.x.logarithmic ? std::pow(10.0, excess.x) : excess.x;
  change.judgement = !(excess.y <= tube.y) ? Judgement::moved : Judgement::within;
  change.moved = plain_number(excess.y, 2) + unit + " off at " + plain_number(x);
  change.allowed = plain_number(tube.y, 2) + unit;
}

void judge_lag(const Figure& before, const Figure& now, std::size_t series, Change& change) {
  if (before.x.logarithmic || before.y.logarithmic) { return; }
  const double lag =
      lag_in_samples(before.series[series].x, before.series[series].y, now.series[series].y);
  if (std::isnan(lag) || std::abs(lag) <= allowed_lag) { return; }
  change.judgement = Judgement::moved;
  change.moved = plain_number(std::abs(lag), 2) + (lag > 0.0 ? " samples late" : " samples early");
  change.allowed = plain_number(allowed_lag, 2) + " samples";
}

Change judge_edge(const Figure& before, const Figure& now, std::size_t series, double spread) {
  const Series& was = before.series[series];
  const Series& is = now.series[series];
  Change change{.item = curve_name(before, series), .unit = before.y.label};
  if (std::string problem = obstacle(was, is); !problem.empty()) {
    change.judgement = Judgement::broken;
    change.moved = std::move(problem);
    return change;
  }
  if (equal(was.x, is.x) && equal(was.y, is.y)) { return change; }
  const double difference = largest_difference(was.y, is.y);
  if (equal(was.x, is.x) && difference <= spread_margin * spread) {
    change.judgement = Judgement::rounding;
    change.moved = plain_number(difference, 2);
    change.allowed = plain_number(spread_margin * spread, 2);
    return change;
  }
  judge_tube(before, now, series, change);
  if (!change.falls()) { judge_lag(before, now, series, change); }
  return change;
}

/// The upper edges of a filled series in place of the lower ones.
Figure upper_edge(Figure figure, std::size_t series) {
  figure.series[series].y = figure.series[series].y2;
  figure.series[series].y2.clear();
  return figure;
}

}  // namespace

Tube tube_around(const Figure& figure, std::size_t series) {
  const Series& curve = figure.series[series];
  Tube tube;
  const double own = range_of(coordinates(curve.y, figure.y.logarithmic));
  const double scale = std::max(own, least_range * range_of_all(figure));
  double greatest = 0.0;
  for (const double y : curve.y) { greatest = std::isfinite(y) ? std::max(greatest, std::abs(y)) : greatest; }
  tube.x = tube_x * range_of(coordinates(curve.x, figure.x.logarithmic));
  // A constant has no range but its own height.
  tube.y = figure.y.logarithmic ? tube_digits : tube_y * (scale > 0.0 ? scale : greatest);
  return tube;
}

Change judge_curve(const Figure& before, const Figure& now, std::size_t series, double spread) {
  Change change = judge_edge(before, now, series, spread);
  const std::vector<double>& edge = before.series[series].y2;
  if (change.falls() || edge.empty()) { return change; }
  if (now.series[series].y2.size() != edge.size()) {
    change.judgement = Judgement::broken;
    change.moved = "its upper edge has " + std::to_string(now.series[series].y2.size()) + " samples";
    return change;
  }
  const Change upper = judge_edge(upper_edge(before, series), upper_edge(now, series), series, spread);
  return static_cast<int>(upper.judgement) > static_cast<int>(change.judgement) ? upper : change;
}

}  // namespace palpate::gate
