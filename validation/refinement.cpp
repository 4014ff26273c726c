// SPDX-License-Identifier: MIT

#include "validation/refinement.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace palpate {

namespace {

/// Curve over time: rows of one value or of the three coordinates of a displacement.
struct Curve {
  const std::vector<double>& time;
  Eigen::MatrixXd values;  ///< coordinates x rows

  [[nodiscard]] double peak() const { return values.colwise().norm().maxCoeff(); }
  [[nodiscard]] Eigen::VectorXd at(double t) const {
    const auto after = std::ranges::upper_bound(time, t);
    if (after == time.begin()) { return values.col(0); }
    if (after == time.end()) { return values.rightCols<1>(); }
    const auto n = after - time.begin();
    const double share = (t - *(after - 1)) / (*after - *(after - 1));
    return (1.0 - share) * values.col(n - 1) + share * values.col(n);
  }
};

/// Returns the curve of some columns; displacements are from the first row.
std::optional<Curve> curve_in(const Trace& trace, const std::vector<std::string>& names,
                              bool from_first) {
  Curve curve{trace.time, Eigen::MatrixXd(std::ssize(names), std::ssize(trace.time))};
  for (std::size_t n = 0; n < names.size(); ++n) {
    const Column* column = trace.find(names[n]);
    if (column == nullptr || column->values.empty()) { return {}; }
    curve.values.row(static_cast<Eigen::Index>(n)) =
        Eigen::Map<const Eigen::RowVectorXd>(column->values.data(), std::ssize(column->values));
  }
  if (from_first) { curve.values.colwise() -= Eigen::VectorXd(curve.values.col(0)); }
  return curve;
}

/// Names of the curves that are compared: force on the tool, position of each record, or that of an
/// oscillator.
std::vector<std::vector<std::string>> compared(const Trace& trace) {
  if (trace.find("tool.force_n") != nullptr) { return {{"tool.force_n"}}; }
  std::vector<std::vector<std::string>> names;
  for (const Column& column : trace.columns) {
    if (column.name == "x_m") { return {{"x_m"}}; }
    if (!column.name.ends_with(".x_m")) { continue; }
    const std::string record = column.name.substr(0, column.name.size() - 3);
    names.push_back({column.name, record + "y_m", record + "z_m"});
  }
  return names;
}

double place_at(const Trace& trace, double time) {
  const auto place = curve_in(trace, {"tool.insertion_m"}, false);
  return place ? place->at(time)(0) : 0.0;
}

/// Times of a run and of the refined run that belong together, linear in between.
struct TimeMap {
  std::vector<double> time{};
  std::vector<double> refined{};

  void add(double t, double u) {
    if (!time.empty() && !(t > time.back() && u > refined.back())) { return; }
    time.push_back(t);
    refined.push_back(u);
  }
  [[nodiscard]] double operator()(double t) const {
    const auto after = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(
        std::ranges::upper_bound(time, t) - time.begin(), 1, std::ssize(time) - 1));
    const double share = (t - time[after - 1]) / (time[after] - time[after - 1]);
    return refined[after - 1] + share * (refined[after] - refined[after - 1]);
  }
};

/// Matches events of the same kind and detail in their order.
TimeMap match_events(const Trace& run, const Trace& refined, RunDifference& difference) {
  TimeMap map;
  map.add(run.time.front(), refined.time.front());
  auto next = refined.events.begin();
  for (const Event& event : run.events) {
    MovedEvent moved{event.kind, event.detail, place_at(run, event.time), {}};
    const auto found = std::find_if(next, refined.events.end(), [&](const Event& other) {
      return other.kind == event.kind && other.detail == event.detail;
    });
    if (found != refined.events.end()) {
      difference.extra_events += found - next;
      moved.refined_place = place_at(refined, found->time);
      map.add(event.time, found->time);
      next = found + 1;
    }
    difference.events.push_back(std::move(moved));
  }
  difference.extra_events += refined.events.end() - next;
  map.add(run.time.back(), refined.time.back());
  return map;
}

}  // namespace

std::optional<RunDifference> difference_of(const Trace& run, const Trace& refined) {
  RunDifference difference;
  if (run.time.size() < 2 || refined.time.size() < 2) { return {}; }
  const TimeMap aligned = match_events(run, refined, difference);
  for (const std::vector<std::string>& names : compared(run)) {
    const bool oscillator_or_force = names.size() == 1;
    const auto a = curve_in(run, names, !oscillator_or_force);
    const auto b = curve_in(refined, names, !oscillator_or_force);
    if (!a || !b || !(a->peak() > 0.0)) { continue; }
    // Rows at rest would dilute the mean.
    const double least = 0.01 * a->peak();
    double sum = 0.0;
    long rows = 0;
    for (std::size_t n = 0; n < run.time.size(); ++n) {
      const Eigen::VectorXd here = a->values.col(static_cast<Eigen::Index>(n));
      const Eigen::VectorXd there = b->at(aligned(run.time[n]));
      if (here.norm() < least && there.norm() < least) { continue; }
      sum += (there - here).squaredNorm();
      ++rows;
    }
    const double curve = std::sqrt(sum / static_cast<double>(std::max(rows, 1L))) / a->peak();
    const double peak = std::abs(b->peak() - a->peak()) / a->peak();
    if (difference.reference > 0.0 && std::max(curve, peak) < difference.share()) { continue; }
    difference.reference = a->peak();
    difference.peak = peak;
    difference.curve = curve;
  }
  if (!(difference.reference > 0.0)) { return {}; }
  return difference;
}

void move_to_finer_nodes(Scene& scene, const SpringNetwork& coarse, const SpringNetwork& fine,
                         const Eigen::Vector3d& spacing) {
  for (Record& record : scene.records) {
    record.where = Eigen::Vector3d(coarse.rest_position.col(record_node(record, coarse)));
  }
  if (scene.loads.empty()) { return; }
  using Key = std::array<long, 3>;
  const auto key_of = [&](const Eigen::Vector3d& place) {
    const Eigen::Vector3d quarters = 4.0 * place.cwiseQuotient(spacing);
    return Key{std::lround(quarters.x()), std::lround(quarters.y()), std::lround(quarters.z())};
  };
  std::map<Key, int> node_at;
  for (int node = 0; node < fine.node_count(); ++node) {
    node_at.emplace(key_of(fine.rest_position.col(node)), node);
  }
  std::vector<Load> loads = resolve_loads(scene, coarse);
  for (Load& load : loads) {
    std::vector<int> nodes;
    for (const int node : load.nodes) {
      const Eigen::Vector3d place = coarse.rest_position.col(node);
      const Key middle = key_of(place);
      const auto find = [&](Key key) {
        const auto found = node_at.find(key);
        return found == node_at.end() ? -1 : found->second;
      };
      std::array<bool, 3> spread{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        Key before = middle;
        Key after = middle;
        before[axis] -= 2;
        after[axis] += 2;
        spread[axis] = find(before) >= 0 && find(after) >= 0;
      }
      // A node that is listed n times has n shares of 1/64 of the force.
      for (int share = 0; share < 64; ++share) {
        Key key = middle;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          constexpr std::array<long, 4> offset{-2, 0, 0, 2};
          if (spread[axis]) {
            key[axis] += offset[static_cast<std::size_t>(share >> 2 * axis & 3)];
          }
        }
        const int there = find(key);
        nodes.push_back(there >= 0 ? there : record_node({.where = place}, fine));
      }
    }
    load.nodes = std::move(nodes);
    load.face.reset();
    load.force /= 64.0;
  }
  scene.loads = std::move(loads);
}

}  // namespace palpate
