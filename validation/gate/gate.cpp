// SPDX-License-Identifier: MIT

#include "validation/gate/gate.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cctype>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <utility>

#include "validation/number_text.hpp"

namespace palpate::gate {

namespace {

std::string bounds_text(const Quantity& q) {
  if (!q.judged()) { return "none"; }
  return plain_number(q.lower, 17) + " to " + plain_number(q.upper, 17);
}

/// Returns true if two bounds are the same up to the changes of a reference; a manual change is
/// larger.
bool same_bound(double before, double now) {
  return now == before || std::abs(now - before) <= allowed_share * std::abs(before);
}

/// Returns the reason why two quantities cannot be compared; empty if they can.
std::string obstacle_of_quantity(const Quantity& before, const Quantity& now) {
  if (now.unit != before.unit) { return "unit " + now.unit + ", was " + before.unit; }
  if (!same_bound(before.lower, now.lower) || !same_bound(before.upper, now.upper) ||
      now.judged() != before.judged()) {
    return "judged by bounds " + bounds_text(now) + ", was " + bounds_text(before);
  }
  // A smaller uncertainty can turn an inconclusive result into a pass. Half of it is far more than
  // rounding changes.
  if (now.judged() && !(now.uncertainty >= 0.5 * before.uncertainty)) {
    return "uncertainty " + plain_number(now.uncertainty) + ", was " +
           plain_number(before.uncertainty);
  }
  if (!std::isfinite(now.value) && now.value != before.value) {
    return "is " + plain_number(now.value);
  }
  if (!std::isfinite(before.value) && now.value != before.value) {
    return "was " + plain_number(before.value);
  }
  if (now.judged() && !now.holds() && before.holds()) {
    return "out of its bounds " + bounds_text(now);
  }
  return {};
}

/// Returns the distance of a value from the best one implied by its bound, to be compared by ratio.
/// NaN without such a bound.
double distance_from_good(const Quantity& q) {
  const bool above = q.lower > -unbounded;
  const bool below = q.upper < unbounded;
  if (above && below && q.upper > q.lower) {
    const double half = 0.5 * (q.upper - q.lower);
    return std::max(std::abs(q.value - (q.lower + half)) / half, least_offset);
  }
  if (above && below) { return std::abs(q.value - q.upper); }
  if (below) { return std::abs(q.value); }
  if (above && q.value > 0.0) { return 1.0 / q.value; }
  return std::nan("");
}

Change found(Change change, ChangeKind kind, std::string moved, std::string allowed = {},
             double excess = 0.0) {
  change.kind = kind;
  change.moved = std::move(moved);
  change.allowed = std::move(allowed);
  change.excess = std::isnan(excess) ? unbounded : excess;
  return change;
}

Change judged(const Change& change, double worse_by, double allowed, const std::string& unit) {
  const bool grew = !(worse_by <= allowed);
  const ChangeKind kind = grew                  ? ChangeKind::worse
                          : worse_by < -allowed ? ChangeKind::better
                                                : ChangeKind::within;
  return found(change, kind,
               plain_number(std::abs(worse_by), 2) + unit + (worse_by > 0.0 ? " worse" : " better"),
               plain_number(allowed, 2) + unit, std::abs(worse_by) / allowed);
}

/// Compares a quantity without a better direction: any change counts.
Change unguided(const Change& change) {
  const double scale = std::abs(change.before);
  const double share = std::abs(change.now - change.before) / scale;
  return found(change, !(share <= allowed_share) ? ChangeKind::moved : ChangeKind::within,
               plain_number(100.0 * (change.now - change.before) / scale, 2) + " %",
               plain_number(100.0 * allowed_share, 2) + " % either way", share / allowed_share);
}

bool is_count(const Quantity& q) { return is_counted(q.unit) || q.value == std::trunc(q.value); }

/// Returns true for an error that became nothing: exactly zero, or rounding of something far
/// larger. Such a result may have compared a thing with itself, or nothing with nothing.
bool vanished(const Quantity& before, const Quantity& now, double rounding) {
  if (is_count(before)) { return false; }
  const double is = std::abs(now.value);
  return is == 0.0 || (is <= rounding && rounding < vanishing * std::abs(before.value));
}

struct Floor {
  std::string_view unit{};
  double difference = 0.0;
};

/// Rounding of a position in a block of 0.1 m is 1e-17 m; some thousand of them make 1e-13 m, a
/// thousandth of the size of an atom. The other floors follow from it.
constexpr std::array<Floor, 18> floors{{
    {"m", 1e-13},
    {"mm", 1e-10},
    {"um", 1e-7},
    {"µm", 1e-7},
    {"m/s", 1e-10},    // of the length in a millisecond
    {"N", 1e-9},       // of the length with 1e4 N/m
    {"mN", 1e-6},      //
    {"Pa", 1e-5},      // of the force on a plunger of 1 cm^2
    {"kPa", 1e-8},     //
    {"mmHg", 1e-7},    //
    {"J", 1e-12},      // of the force along a millimetre
    {"mJ", 1e-9},      //
    {"N s", 1e-12},    // of the force in a millisecond
    {"N/m", 1e-9},     // of the force along a metre
    {"N s/m", 1e-12},  // of the force at 1 m/s in a millisecond
    {"s", 1e-13},      // of a time of a hundred seconds, a dozen roundings
    {"1", 1e-13},      // some hundred roundings of one
    {"", 1e-13},       // a ratio
}};

}  // namespace

double floor_of(std::string_view unit) {
  const auto* found = std::ranges::find(floors, unit, &Floor::unit);
  return found == floors.end() ? 0.0 : found->difference;
}

std::string_view name_of(ChangeKind kind) {
  constexpr std::array<std::string_view, 7> names{"same",  "rounding", "within", "better",
                                                  "worse", "moved",    "broken"};
  return names[static_cast<std::size_t>(kind)];
}

Change compare_quantity(const Quantity& before, const Quantity& now, double spread) {
  Change change{.item = before.name, .before = before.value, .now = now.value, .unit = before.unit};
  if (std::string problem = obstacle_of_quantity(before, now); !problem.empty()) {
    return found(change, ChangeKind::broken, std::move(problem));
  }
  if (now.value == before.value) {
    return now.bound_from == before.bound_from
               ? change
               : found(change, ChangeKind::within,
                       "bound from \"" + now.bound_from + "\", was \"" + before.bound_from + "\"");
  }
  const double difference = std::abs(now.value - before.value);
  const auto absolute = [&](ChangeKind kind, double allowed) {
    return found(change, kind, plain_number(difference, 2) + " " + before.unit,
                 plain_number(allowed, 2) + " " + before.unit, difference / allowed);
  };
  if (!before.judged() && before.uncertainty > 0.0) {
    // Both files state two steps for an event. The smaller number counts, so that a forged one
    // hides nothing.
    const bool event = before.name.starts_with(event_prefix);
    const double uncertainty =
        event ? std::min(before.uncertainty, now.uncertainty) : before.uncertainty;
    const double allowed = uncertainty + spread + floor_of(before.unit);
    return absolute(difference <= allowed ? ChangeKind::within : ChangeKind::moved, allowed);
  }
  const double rounding = std::max(spread_margin * spread, floor_of(before.unit));
  if (difference <= rounding) { return absolute(ChangeKind::rounding, rounding); }
  if (before.unit == "digits") {
    return judged(change, before.value - now.value, allowed_digits, " digits");
  }
  if (is_counted(before.unit)) {
    return judged(change, 100.0 * (now.value / before.value - 1.0), 100.0 * allowed_share, " %");
  }
  const double was = distance_from_good(before);
  const double is = distance_from_good(now);
  if (std::isnan(was) || std::isnan(is)) { return unguided(change); }
  if (vanished(before, now, rounding)) {
    return found(change, ChangeKind::broken,
                 "vanished; an error of nothing cannot be judged, approve it if it is right");
  }
  return judged(change, was == is ? 0.0 : std::log10(is / was), allowed_digits, " digits");
}

namespace {

struct Range {
  double least = unbounded;
  double greatest = -unbounded;

  void add(double y) {
    least = std::min(least, y);
    greatest = std::max(greatest, y);
  }
};

/// Returns the value on the chord between the neighbours; at the ends the value of the end.
double value_at(const Path& path, double x) {
  const auto right = std::ranges::lower_bound(path.x, x);
  if (right == path.x.begin()) { return path.y.front(); }
  if (right == path.x.end()) { return path.y.back(); }
  const auto n = static_cast<std::size_t>(std::distance(path.x.begin(), right));
  const double width = path.x[n] - path.x[n - 1];
  const double share = width > 0.0 ? (x - path.x[n - 1]) / width : 1.0;
  return path.y[n - 1] + share * (path.y[n] - path.y[n - 1]);
}

/// Returns the range of a curve within [begin, end].
Range range_within(const Path& path, double begin, double end) {
  Range range;
  range.add(value_at(path, begin));
  range.add(value_at(path, end));
  const auto first = std::ranges::lower_bound(path.x, begin);
  for (auto at = first; at != path.x.end() && *at <= end; ++at) {
    range.add(path.y[static_cast<std::size_t>(std::distance(path.x.begin(), at))]);
  }
  return range;
}

Excess excess_over(const Path& path, const Path& other, double half_width) {
  Excess largest;
  for (std::size_t n = 0; n < path.x.size(); ++n) {
    const double x = path.x[n];
    const bool beyond = x < other.x.front() - half_width || x > other.x.back() + half_width;
    const Range range = range_within(other, x - half_width, x + half_width);
    const double y =
        beyond ? unbounded : std::max({range.least - path.y[n], path.y[n] - range.greatest, 0.0});
    if (y > largest.y) { largest = {.y = y, .x = x}; }
  }
  return largest;
}

}  // namespace

Excess largest_excess(const Path& before, const Path& now, double half_width_x) {
  const Excess out = excess_over(now, before, half_width_x);
  const Excess missing = excess_over(before, now, half_width_x);
  return out.y >= missing.y ? out : missing;
}

namespace {

/// Returns the columns of the fit: the effects on `before` of a lag of one sample, a gain of one
/// and an offset of one.
Eigen::MatrixXd directions_of(const Eigen::Ref<const Eigen::VectorXd>& before) {
  const Eigen::Index inner = before.size() - 2;
  Eigen::MatrixXd columns(inner, 3);
  columns.col(0) = -0.5 * (before.tail(inner) - before.head(inner));
  columns.col(1) = before.segment(1, inner);
  columns.col(2).setOnes();
  return columns;
}

bool evenly_spaced(const std::vector<double>& x) {
  const double step = (x.back() - x.front()) / static_cast<double>(x.size() - 1);
  constexpr double rounding = 1e-6;
  for (std::size_t n = 1; n < x.size(); ++n) {
    if (!(std::abs(x[n] - x[n - 1] - step) <= rounding * std::abs(step))) { return false; }
  }
  return step != 0.0;
}

}  // namespace

double lag_in_samples(const std::vector<double>& x, const std::vector<double>& before,
                      const std::vector<double>& now) {
  constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
  constexpr double collinear = 1e-3;  // a delayed ramp equals a ramp with an offset
  if (before.size() < least_samples_for_lag || now.size() != before.size() || !evenly_spaced(x)) {
    return nothing;
  }
  const auto size = static_cast<Eigen::Index>(before.size());
  const Eigen::Map<const Eigen::VectorXd> was(before.data(), size);
  const Eigen::Map<const Eigen::VectorXd> is(now.data(), size);
  Eigen::MatrixXd columns = directions_of(was);
  const Eigen::VectorXd difference = (is - was).segment(1, size - 2);
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> solver;
  const Eigen::RowVectorXd scale = columns.colwise().norm();
  if (!(scale.minCoeff() > 0.0)) { return nothing; }
  columns.array().rowwise() /= scale.array();
  solver.setThreshold(collinear);
  solver.compute(columns);
  if (solver.rank() < 3) { return nothing; }
  Eigen::VectorXd found = solver.solve(difference);
  const double lag = found(0) / scale(0);
  const double told = found(0) * found(0) / difference.squaredNorm();  // columns have length one
  return told >= 0.5 ? lag : nothing;
}

namespace {

/// Returns the unit in the label of an axis: "N" of "force (N)"; empty for a ratio.
std::string_view unit_of(const Axis& axis) {
  const std::string_view label = axis.label;
  const std::size_t begin = label.rfind('(');
  return label.ends_with(')') && begin != label.npos
             ? label.substr(begin + 1, label.size() - begin - 2)
             : std::string_view();
}

/// Returns the position of a value on an axis. Values below the floor of the unit have no size.
double coordinate(double value, const Axis& axis) {
  if (!axis.logarithmic) { return value; }
  return std::log10(std::isnan(value) ? value : std::max(std::abs(value), floor_of(unit_of(axis))));
}

std::vector<double> coordinates(const std::vector<double>& values, const Axis& axis) {
  std::vector<double> list(values);
  for (double& each : list) { each = coordinate(each, axis); }
  return list;
}

double range_of(const std::vector<double>& values) {
  Range range;
  for (const double value : values) {
    if (std::isfinite(value)) { range.add(value); }
  }
  return range.greatest > range.least ? range.greatest - range.least : 0.0;
}

/// Returns the range of all curves of a figure.
double range_of_all(const Figure& figure) {
  std::vector<double> all;
  for (const Series& each : figure.series) { all.insert(all.end(), each.y.begin(), each.y.end()); }
  return range_of(coordinates(all, figure.y));
}

/// Checks sizes and gaps: values that are not finite must be at the same positions.
std::string obstacle_of_curve(const Series& before, const Series& now) {
  if (now.x.size() != now.y.size()) { return "x and y of different lengths"; }
  if (now.label != before.label) {
    return "is called \"" + now.label + "\", was \"" + before.label + "\"";
  }
  if (now.y.size() != before.y.size()) {
    return std::to_string(now.y.size()) + " samples, was " + std::to_string(before.y.size());
  }
  for (std::size_t n = 0; n < now.y.size(); ++n) {
    const bool same_y = std::isfinite(now.y[n]) == std::isfinite(before.y[n]);
    const bool same_x = std::isfinite(now.x[n]) == std::isfinite(before.x[n]);
    if (!same_x || !same_y) {
      return "sample " + std::to_string(n) + " is " + plain_number(now.y[n]) + " at " +
             plain_number(now.x[n]) + ", was " + plain_number(before.y[n]);
    }
  }
  return {};
}

bool equal(const std::vector<double>& a, const std::vector<double>& b) {
  return std::ranges::equal(
      a, b, [](double p, double q) { return p == q || (std::isnan(p) && std::isnan(q)); });
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0.0;
  for (std::size_t n = 0; n < a.size(); ++n) {
    if (std::isfinite(a[n])) { largest = std::max(largest, std::abs(a[n] - b[n])); }
  }
  return largest;
}

/// Returns the finite points of a curve from left to right.
Path path_of(const Series& series, const Figure& figure) {
  Path path;
  for (std::size_t n = 0; n < series.x.size(); ++n) {
    const double x = coordinate(series.x[n], figure.x);
    const double y = coordinate(series.y[n], figure.y);
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

/// Compares points, and curves whose x is not monotonic, sample by sample.
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
  return curves ? largest_excess(before, now, half_width_x)
                : excess_by_sample(before, now, half_width_x);
}

double edge_difference(const Figure& before, const Figure& now, std::size_t series) {
  const Series& was = before.series[series];
  const Series& is = now.series[series];
  if (!obstacle_of_curve(was, is).empty()) { return std::nan(""); }
  if (before.x.logarithmic || before.y.logarithmic) { return largest_difference(was.y, is.y); }
  return excess_of(path_of(was, before), path_of(is, now), tube_around(before, series).x, was.style)
      .y;
}

Change compare_within_tube(const Figure& before, const Figure& now, std::size_t series,
                           const Change& change) {
  const Tube tube = tube_around(before, series);
  const Excess excess =
      excess_of(path_of(before.series[series], before), path_of(now.series[series], now), tube.x,
                before.series[series].style);
  const auto with_unit = [](const std::string& number, std::string_view unit) {
    return unit.empty() || unit == "1" ? number : number + " " + std::string(unit);
  };
  const std::string_view unit = before.y.logarithmic ? "digits" : unit_of(before.y);
  const double x = before.x.logarithmic ? std::pow(10.0, excess.x) : excess.x;
  return found(change, !(excess.y <= tube.y) ? ChangeKind::moved : ChangeKind::within,
               with_unit(plain_number(excess.y, 2), unit) + " off at " +
                   with_unit(plain_number(x), unit_of(before.x)),
               with_unit(plain_number(tube.y, 2), unit), excess.y / tube.y);
}

Change compare_lag(const Figure& before, const Figure& now, std::size_t series,
                   const Change& change) {
  if (before.x.logarithmic || before.y.logarithmic) { return change; }
  const double lag =
      lag_in_samples(before.series[series].x, before.series[series].y, now.series[series].y);
  if (std::isnan(lag) || std::abs(lag) <= allowed_lag) { return change; }
  return found(change, ChangeKind::moved,
               plain_number(std::abs(lag), 2) + (lag > 0.0 ? " samples late" : " samples early"),
               plain_number(allowed_lag, 2) + " samples", std::abs(lag) / allowed_lag);
}

Change compare_edge(const Figure& before, const Figure& now, std::size_t series, double spread) {
  const Series& was = before.series[series];
  const Series& is = now.series[series];
  Change change{.item = curve_name(before, series), .unit = before.y.label};
  if (std::string problem = obstacle_of_curve(was, is); !problem.empty()) {
    return found(change, ChangeKind::broken, std::move(problem));
  }
  if (equal(was.x, is.x) && equal(was.y, is.y)) { return change; }
  const double difference = edge_difference(before, now, series);
  const double rounding = std::max(spread_margin * spread, floor_of(unit_of(before.y)));
  if (equal(was.x, is.x) && difference <= rounding) {
    return found(change, ChangeKind::rounding, plain_number(difference, 2),
                 plain_number(rounding, 2));
  }
  change = compare_within_tube(before, now, series, change);
  return change.fails() ? change : compare_lag(before, now, series, change);
}

/// Returns a filled series with the upper edges in place of the lower ones.
Figure upper_edge(Figure figure, std::size_t series) {
  figure.series[series].y = figure.series[series].y2;
  figure.series[series].y2.clear();
  return figure;
}

}  // namespace

Tube tube_around(const Figure& figure, std::size_t series) {
  const Series& curve = figure.series[series];
  Tube tube;
  const double own = range_of(coordinates(curve.y, figure.y));
  const double scale = std::max(own, least_range * range_of_all(figure));
  double greatest = 0.0;
  for (const double y : curve.y) {
    greatest = std::isfinite(y) ? std::max(greatest, std::abs(y)) : greatest;
  }
  const double length = range_of(coordinates(curve.x, figure.x));
  const auto samples = static_cast<double>(std::max<std::size_t>(curve.x.size(), 2) - 1);
  tube.x = std::min(tube_x, tube_samples / samples) * length;
  // The range of a constant is its absolute value.
  const double range = scale > 0.0 ? scale : greatest;
  tube.y =
      figure.y.logarithmic ? tube_digits : std::max(tube_y * range, floor_of(unit_of(figure.y)));
  return tube;
}

double curve_difference(const Figure& before, const Figure& now, std::size_t series) {
  const double lower = edge_difference(before, now, series);
  const bool band = !before.series[series].y2.empty();
  if (!band || now.series[series].y2.size() != now.series[series].y.size()) { return lower; }
  return std::max(lower,
                  edge_difference(upper_edge(before, series), upper_edge(now, series), series));
}

Change compare_curve(const Figure& before, const Figure& now, std::size_t series, double spread) {
  Change change = compare_edge(before, now, series, spread);
  const std::vector<double>& edge = before.series[series].y2;
  if (change.fails() || edge.empty()) { return change; }
  if (now.series[series].y2.size() != edge.size()) {
    return found(change, ChangeKind::broken,
                 "its upper edge has " + std::to_string(now.series[series].y2.size()) + " samples");
  }
  const Change upper =
      compare_edge(upper_edge(before, series), upper_edge(now, series), series, spread);
  return upper.kind > change.kind ? upper : change;
}

namespace {

Change broken(std::string item, std::string what) {
  return {.item = std::move(item), .kind = ChangeKind::broken, .moved = std::move(what)};
}

std::string sentence_of(const Change& change) {
  return std::string(name_of(change.kind)) + ": " + change.item + (change.item.empty() ? "" : " ") +
         change.moved + (change.allowed.empty() ? "" : "; allowed " + change.allowed);
}

/// Sorts the changes, worst first, and concludes from them.
CaseChanges concluded(const Outcome& of, std::vector<Change> changes) {
  CaseChanges result{
      .outcome = {.name = of.name, .suite = of.suite, .claim = "Not worse than what was accepted."},
      .changes = std::move(changes)};
  std::ranges::stable_sort(result.changes, std::ranges::greater{}, [](const Change& change) {
    return std::pair(change.kind, change.excess);
  });
  std::vector<Reason> parts{{Status::pass}};
  for (const Change& change : result.changes) {
    if (change.fails()) { parts.push_back({Status::fail, sentence_of(change)}); }
  }
  conclude(result.outcome, std::move(parts));
  return result;
}

double spread_of(const std::map<std::string, double>& spreads, const std::string& name) {
  const auto found = spreads.find(name);
  return found == spreads.end() ? 0.0 : found->second;
}

/// Checks the status: a judged case must be judged again, a passed one must pass, one that is
/// judged for the first time must pass too, and none may end in an error.
std::string status_problem(const Outcome& before, const Outcome& now) {
  const std::string why = now.reasons.empty() ? "" : ": " + now.reason();
  const std::string is = "is " + std::string(name_of(now.status)) + why;
  if (now.status == Status::error) { return is; }
  if (now.status == before.status || now.status == Status::pass) { return {}; }
  return is + ", was " + std::string(name_of(before.status));
}

/// Compares the elements of two lists that have the same name.
template <class Items, class Name, class Compare>
void compare_by_name(const Items& before, const Items& now, Name name, const char* what,
                     std::vector<Change>& changes, Compare&& compare) {
  for (const auto& one : before) {
    const auto found = std::ranges::find(now, one.*name, name);
    if (found == now.end()) {
      changes.push_back(broken(one.*name, std::string(what) + "is missing"));
    } else {
      compare(one, *found);
    }
  }
  for (auto one = now.begin(); one != now.end(); ++one) {
    if (std::ranges::find(before, (*one).*name, name) == before.end()) {
      changes.push_back(broken((*one).*name, std::string(what) + "is not in the baseline"));
    } else if (std::ranges::find(now, (*one).*name, name) != one) {
      changes.push_back(broken((*one).*name, std::string(what) + "is there twice"));
    }
  }
}

bool same(const Axis& a, const Axis& b) {
  return a.label == b.label && a.logarithmic == b.logarithmic;
}

std::string axes_of(const Figure& figure) { return figure.y.label + " over " + figure.x.label; }

void compare_figure(const AcceptedCase& accepted, const Figure& before, const Figure& now,
                    std::vector<Change>& changes) {
  if (!same(before.x, now.x) || !same(before.y, now.y)) {
    changes.push_back(broken(before.id, "shows " + axes_of(now) + ", was " + axes_of(before)));
    return;
  }
  if (before.series.size() != now.series.size()) {
    changes.push_back(broken(before.id, std::to_string(now.series.size()) + " curves, was " +
                                            std::to_string(before.series.size())));
    return;
  }
  for (std::size_t n = 0; n < before.series.size(); ++n) {
    changes.push_back(
        compare_curve(before, now, n, spread_of(accepted.spread.curves, curve_name(before, n))));
  }
}

/// Compares the texts of a case, such as the kernel. Those of the scene come first.
void compare_texts(const Outcome& before, const Outcome& now, std::vector<Change>& changes) {
  const std::map<std::string, std::string> was = compared_texts(before);
  const std::map<std::string, std::string> is = compared_texts(now);
  std::vector<Change> found;
  for (const auto& [name, text] : was) {
    const auto other = is.find(name);
    if (text == depends_on_rounding || name.starts_with(reduction_warning)) { continue; }
    if (other == is.end()) {
      found.push_back(broken(name, "is gone" + (text.empty() ? "" : ", was " + text)));
    } else if (other->second != text) {
      found.push_back(broken(name, "is " + other->second + ", was " + text));
      found.back().text_before = text;
      found.back().text_now = other->second;
    }
  }
  for (const auto& [name, text] : is) {
    if (!was.contains(name) && !name.starts_with(reduction_warning)) {
      found.push_back(broken(name, "is new" + (text.empty() ? "" : ": " + text)));
    }
  }
  std::ranges::stable_partition(
      found, [](const Change& change) { return change.item.starts_with(scene_prefix); });
  std::ranges::move(found, std::back_inserter(changes));
}

/// Checks that events are in their order. Rounding may exchange events that are closer than the
/// uncertainty of their times, but not two of one tick that stay there.
void compare_order(const Outcome& before, const Outcome& now, std::vector<Change>& changes) {
  std::vector<std::pair<const Quantity*, const Quantity*>> events;  // accepted and new, as new
  for (const Quantity& event : now.quantities) {
    const auto found = std::ranges::find(before.quantities, event.name, &Quantity::name);
    if (!event.name.starts_with(event_prefix) || found == before.quantities.end()) { continue; }
    for (const auto& [earlier, earlier_now] : events) {
      const double apart = earlier->value - found->value;
      const bool stay = apart == 0.0 && earlier_now->value == event.value;
      const bool exchanged = earlier > &*found && (apart > found->uncertainty || stay);
      if (!exchanged && !(earlier_now->value > event.value)) { continue; }
      changes.push_back(broken(event.name, "is listed after " + earlier->name + ", at " +
                                               plain_number(event.value) + " s and " +
                                               plain_number(earlier_now->value) + " s"));
      return;
    }
    events.emplace_back(&*found, &event);
  }
}

struct CommandWords {
  std::string command{};             ///< program and command
  std::vector<std::string> cases{};  ///< before the first option, in an order of their own
  std::vector<std::string> options{};
};

/// Returns a command with the last part of every path in it, wherever the files are.
std::string without_folders(const std::string& command) {
  std::istringstream words(command);
  std::string all;
  for (std::string word; words >> word;) {
    all += (all.empty() ? "" : " ") + word.substr(word.find_last_of('/') + 1);
  }
  return all;
}

/// Returns JSON without the spaces between its parts.
std::string without_spaces(const std::string& json) {
  std::string all;
  bool in_text = false;
  for (std::size_t n = 0; n < json.size(); ++n) {
    if (json[n] == '"' && (n == 0 || json[n - 1] != '\\')) { in_text = !in_text; }
    if (in_text || std::isspace(static_cast<unsigned char>(json[n])) == 0) { all += json[n]; }
  }
  return all;
}

/// Splits a command line, without options and folders that do not affect judged results.
CommandWords words_of(const std::string& line) {
  CommandWords words;
  std::size_t number = 0;
  for (const std::string& word : shell_words(line)) {
    if (number++ < 2) {
      words.command += (number == 1 ? "" : " ") + word;
      continue;
    }
    std::vector<std::string>& list =
        words.options.empty() && !word.starts_with('-') ? words.cases : words.options;
    list.push_back(word);
  }
  const auto remove = [&words](const std::string& option, std::ptrdiff_t count,
                               const std::string& value = {}) {
    const auto at = std::ranges::find(words.options, option);
    if (std::distance(at, words.options.end()) < count) { return; }
    if (value.empty() || *std::next(at) == value) { words.options.erase(at, at + count); }
  };
  remove("--no-skip", 1);
  remove("--in-process", 1);
  remove("--subject-time-limit", 2);
  remove("--subject-memory-limit", 2);
  const auto change = [&words](const std::string& option, auto changed) {
    const auto at = std::ranges::find(words.options, option);
    if (std::distance(at, words.options.end()) > 1) { *std::next(at) = changed(*std::next(at)); }
  };
  change("--subject-options", without_spaces);
  change("--subject", without_folders);
  change("--expected", without_folders);
  remove("--subject-options", 2, "{}");
  remove("--seed", 2);  // of scenes that are drawn anew at every run
  remove("--subject", 2, "model");
  std::ranges::sort(words.cases);
  words.cases.erase(std::ranges::unique(words.cases).begin(), words.cases.end());
  return words;
}

}  // namespace

std::vector<std::string> shell_words(const std::string& line) {
  std::vector<std::string> words;
  char quote = '\0';
  bool begins = true;
  for (std::size_t n = 0; n < line.size(); ++n) {
    const char c = line[n];
    if (c == ' ' && quote == '\0') {
      begins = true;
      continue;
    }
    if (std::exchange(begins, false)) { words.emplace_back(); }
    if (c == quote) {
      quote = '\0';
    } else if (quote == '\0' && (c == '\'' || c == '"')) {
      quote = c;
    } else if (c == '\\' && quote != '\'' && n + 1 < line.size()) {
      words.back() += line[++n];
    } else {
      words.back() += c;
    }
  }
  return words;
}

std::string command_problem(const std::string& accepted, const std::string& candidate,
                            bool in_part) {
  const CommandWords now = words_of(candidate);
  const CommandWords before = words_of(accepted);
  if (now.command == before.command && now.options == before.options &&
      (in_part || now.cases == before.cases)) {
    return {};
  }
  return "results of `" + candidate + "`, the baseline has those of `" + accepted + "`";
}

bool CaseChanges::better() const {
  return !fails() && std::ranges::any_of(changes, [](const Change& change) {
    return change.kind == ChangeKind::better;
  });
}

ChangeCounts GateResult::counts() const {
  ChangeCounts sum;
  for (const CaseChanges& one : cases) {
    int& count = one.fails()     ? sum.failed
                 : one.identical ? sum.identical
                 : one.better()  ? sum.better
                                 : sum.unchanged;
    ++count;
  }
  return sum;
}

Outcome GateResult::outcome() const {
  Outcome outcome{
      .name = "gate", .suite = "gate", .claim = "No case is worse than what was accepted."};
  std::vector<Reason> parts;
  for (const std::string& fault : faults) { parts.push_back({Status::error, fault}); }
  for (const CaseChanges& one : cases) {
    parts.push_back({one.outcome.status, one.fails()
                                             ? one.outcome.name + ": " + one.outcome.reasons.front()
                                             : std::string()});
  }
  conclude(outcome, std::move(parts));
  return outcome;
}

std::vector<Outcome> GateResult::outcomes() const {
  std::vector<Outcome> list;
  for (const std::string& fault : faults) {
    list.push_back({.name = "comparison",
                    .suite = "gate",
                    .claim = "Results and baseline belong together.",
                    .status = Status::error,
                    .reasons = {fault}});
  }
  for (const CaseChanges& one : cases) { list.push_back(one.outcome); }
  return list;
}

CaseChanges compare_case(const AcceptedCase& accepted, const Outcome& now) {
  std::vector<Change> changes;
  if (std::string problem = status_problem(accepted.outcome, now); !problem.empty()) {
    changes.push_back(broken("", std::move(problem)));
  }
  if (now.suite != accepted.outcome.suite) {
    changes.push_back(
        broken("suite", "is \"" + now.suite + "\", was \"" + accepted.outcome.suite + "\""));
  }
  if (now.claim != accepted.outcome.claim) {
    const bool of_run = accepted.outcome.suite == "run";  // its claim is the title of the scene
    changes.push_back(broken(of_run ? std::string(scene_prefix) + "title" : "claim",
                             "is \"" + now.claim + "\", was \"" + accepted.outcome.claim + "\""));
    changes.back().text_before = accepted.outcome.claim;
    changes.back().text_now = now.claim;
  }
  const bool was_judged = accepted.outcome.status != Status::skip;
  const bool is_judged = now.status != Status::skip;
  if (was_judged && is_judged) {
    compare_texts(accepted.outcome, now, changes);  // first, because they explain the others
    compare_by_name(accepted.outcome.quantities, now.quantities, &Quantity::name, "", changes,
                    [&](const Quantity& before, const Quantity& after) {
                      changes.push_back(compare_quantity(
                          before, after, spread_of(accepted.spread.quantities, before.name)));
                    });
    compare_by_name(accepted.outcome.figures, now.figures, &Figure::id, "the figure ", changes,
                    [&](const Figure& before, const Figure& after) {
                      compare_figure(accepted, before, after, changes);
                    });
    compare_order(accepted.outcome, now, changes);
  }
  std::erase_if(changes, [](const Change& change) { return change.kind == ChangeKind::same; });
  CaseChanges result = concluded(now, std::move(changes));
  result.identical = was_judged ? is_judged && result.changes.empty() : !is_judged;
  return result;
}

GateResult compare(const Baseline& baseline, const Candidate& candidate,
                   const std::vector<std::string>& only) {
  GateResult result;
  const auto wanted = [&](const std::string& name) {
    return only.empty() || std::ranges::find(only, name) != only.end();
  };
  // The same cases may be selected by other words; one that is missing is found below.
  if (std::string problem = command_problem(baseline.command, candidate.command, true);
      !problem.empty()) {
    result.faults.push_back(std::move(problem));
  }
  std::map<std::string_view, const Outcome*> of_name;
  for (const Outcome& outcome : candidate.outcomes) {
    if (!of_name.emplace(outcome.name, &outcome).second) {
      result.faults.push_back(outcome.name + " is twice in the results");
    }
  }
  std::set<std::string> met;
  for (const AcceptedCase& accepted : baseline.cases) {
    const std::string& name = accepted.outcome.name;
    if (!wanted(name)) { continue; }
    met.insert(name);
    const auto found = of_name.find(name);
    result.cases.push_back(
        found == of_name.end()
            ? concluded(accepted.outcome, {broken("", "is missing from the results")})
            : compare_case(accepted, comparable(*found->second)));
  }
  for (const Outcome& outcome : candidate.outcomes) {
    if (!wanted(outcome.name) || !met.insert(outcome.name).second) { continue; }
    result.cases.push_back(
        concluded(outcome, {broken("", "is not in the baseline; palpate approve takes it in")}));
  }
  for (const std::string& name : only) {
    if (!met.contains(name)) {
      result.faults.push_back(name + " is neither in the results nor in the baseline");
    }
  }
  if (result.cases.empty()) { result.faults.emplace_back("nothing was compared"); }
  return result;
}

}  // namespace palpate::gate
