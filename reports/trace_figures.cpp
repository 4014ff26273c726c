// SPDX-License-Identifier: MIT
#include "reports/trace_figures.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "reports/markup.hpp"
#include "reports/tool_pass.hpp"

namespace palpate {

namespace {

/// Neighbouring columns that belong in one picture.
struct Group {
  std::string record;
  std::string unit;
  std::vector<const Column*> columns;
};

/// "tip" and "vx" of "tip.vx_m_per_s".
std::string record_of(const Column& column) {
  const std::size_t dot = column.name.rfind('.');
  return dot == std::string::npos ? "" : column.name.substr(0, dot);
}
std::string short_name(const Column& column) {
  const std::size_t dot = column.name.rfind('.');
  const std::string name = dot == std::string::npos ? column.name : column.name.substr(dot + 1);
  const std::size_t unit = name.find('_');
  return unit == 0 ? name : name.substr(0, unit);
}

std::vector<Group> groups_of(const Trace& trace) {
  std::vector<Group> groups;
  for (const Column& column : trace.columns) {
    if (is_tool_column(column.name)) { continue; }
    const std::string record = record_of(column);
    if (groups.empty() || groups.back().record != record || groups.back().unit != column.unit) {
      groups.push_back({record, column.unit, {}});
    }
    groups.back().columns.push_back(&column);
  }
  return groups;
}

bool as_displacement(const Group& group) {
  return group.unit == "m" && !group.record.empty() && short_name(*group.columns.front()) == "x";
}

std::string subject_of(const Group& group) {
  static const std::map<std::string, std::string> unit_subjects{
      {"m", "position"}, {"m/s", "velocity"}, {"N", "force"}, {"Pa", "pressure"}};
  if (as_displacement(group)) { return "displacement"; }
  if (group.columns.size() == 1) { return short_name(*group.columns.front()); }
  const auto found = unit_subjects.find(group.unit);
  return found == unit_subjects.end() ? "value" : found->second;
}

Figure figure_of(const Group& group, const Trace& trace, std::size_t index) {
  const std::string subject = subject_of(group);
  Figure figure{
      .id = "trace-" + std::to_string(index),
      .title = group.record.empty() ? subject : group.record + ": " + subject,
      .caption = as_displacement(group) ? "Displacement from the first tick." : "At every tick.",
      .x = {.label = "time (s)"},
      .y = {.label = subject + " (" + group.unit + ")"}};
  for (const Column* column : group.columns) {
    Series series{.label = short_name(*column), .x = trace.time, .y = column->values};
    if (as_displacement(group)) {
      for (double& y : series.y) { y -= column->values.front(); }
    }
    figure.series.push_back(std::move(series));
  }
  return figure;
}

/// The frame and the node of the largest displacement from the first frame.
struct Furthest {
  std::size_t frame = 0;
  Eigen::Index node = 0;
  double distance = 0.0;
};

Furthest furthest_of(const Trace& trace) {
  Furthest furthest;
  for (std::size_t n = 1; n < trace.frames.size(); ++n) {
    if (trace.frames[n].cols() != trace.frames[0].cols() || !trace.frames[n].allFinite()) {
      continue;
    }
    Eigen::Index node = 0;
    const double distance = (trace.frames[n] - trace.frames[0]).colwise().norm().maxCoeff(&node);
    if (distance > furthest.distance) { furthest = {n, node, distance}; }
  }
  return furthest;
}

Figure slice(const Trace& trace, const Furthest& furthest) {
  const NodeVectors& rest = trace.frames.front();
  const NodeVectors& moved = trace.frames[furthest.frame];
  const Eigen::Vector3d extent = rest.rowwise().maxCoeff() - rest.rowwise().minCoeff();
  const double factor = enlargement(furthest.distance, extent.maxCoeff());
  const double half_thickness = std::max(0.02 * extent.y(), 1e-9);
  Series before{.label = "at rest", .style = Series::Style::points};
  const double time =
      furthest.frame < trace.frame_time.size() ? trace.frame_time[furthest.frame] : 0.0;
  Series after{.label = "at " + short_number(time) + " s", .style = Series::Style::points};
  for (Eigen::Index i = 0; i < rest.cols(); ++i) {
    if (std::abs(rest(1, i) - rest(1, furthest.node)) > half_thickness) { continue; }
    const Eigen::Vector3d drawn = rest.col(i) + factor * (moved.col(i) - rest.col(i));
    before.x.push_back(1e3 * rest(0, i));
    before.y.push_back(1e3 * rest(2, i));
    after.x.push_back(1e3 * drawn.x());
    after.y.push_back(1e3 * drawn.z());
  }
  Figure figure{.id = "snapshot",
                .title = "Largest displacement",
                .caption = "Nodes of the slice y = " + short_number(1e3 * rest(1, furthest.node)) +
                           " mm at rest and when one of them has moved furthest, by " +
                           short_number(1e3 * furthest.distance) + " mm; displacements are drawn " +
                           (factor == 1.0 ? "to scale" : short_number(factor) + " times larger") +
                           ". The skin is above.",
                .x = {.label = "x (mm)"},
                .y = {.label = "z (mm)"},
                .series = {before, after},
                .square = true};
  const auto [low, high] = std::ranges::minmax(before.y);
  const double rim = 0.08 * std::max(high - low, 1e3 * extent.x());
  figure.y.minimum = high + rim;  // z points into the tissue, so it grows downwards
  figure.y.maximum = low - rim;
  return figure;
}

}  // namespace

std::vector<Figure> figures_over_time(const Trace& trace) {
  std::vector<Figure> figures;
  if (trace.time.size() < 2) { return figures; }
  for (const Group& group : groups_of(trace)) {
    figures.push_back(figure_of(group, trace, figures.size()));
  }
  return figures;
}

double enlargement(double distance, double extent) {
  const double wanted = 0.06 * extent / distance;
  if (wanted <= 1.0) { return 1.0; }
  const double decade = std::pow(10.0, std::floor(std::log10(wanted)));
  return decade * (wanted / decade >= 5.0 ? 5.0 : wanted / decade >= 2.0 ? 2.0 : 1.0);
}

std::optional<Figure> snapshot_figure(const Trace& trace) {
  constexpr Eigen::Index fewest_nodes = 8;
  if (trace.frames.size() < 2 || trace.frames.front().cols() < fewest_nodes) {
    return std::nullopt;
  }
  const Furthest furthest = furthest_of(trace);
  if (furthest.distance <= 0.0) { return std::nullopt; }
  return slice(trace, furthest);
}

}  // namespace palpate
