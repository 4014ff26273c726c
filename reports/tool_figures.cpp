// SPDX-License-Identifier: MIT
#include "reports/tool_figures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "model/dynamics/pressure_units.hpp"
#include "reports/shown_units.hpp"
#include "reports/tool_pass.hpp"

namespace palpate {

namespace {

constexpr double least_lateral = 1e-6;  // [N] below it there is only rounding

struct Part {
  const char* column;
  const char* label;
};
constexpr std::array<Part, 3> parts{{{"tool.friction_n", "friction of the shaft"},
                                     {"tool.cutting_n", "cutting at the tip"},
                                     {"tool.stiffness_n", "stiffness of the tissue"}}};

std::vector<double> picked(const std::vector<double>& values, const std::vector<std::size_t>& rows,
                           double factor = 1.0) {
  std::vector<double> out;
  out.reserve(rows.size());
  for (const std::size_t row : rows) { out.push_back(factor * values[row]); }
  return out;
}

double largest(const Trace& trace, const char* column) {
  double most = 0.0;
  if (trace.find(column) == nullptr) { return most; }
  for (const double value : values_of(trace, column)) {
    if (std::isfinite(value)) { most = std::max(most, std::abs(value)); }
  }
  return most;
}

/// A tool with a shaft and an edge; a probe has neither.
bool cuts(const Trace& trace) {
  return largest(trace, "tool.cutting_n") > 0.0 || largest(trace, "tool.friction_n") > 0.0;
}

bool returns(const Trace& trace) {
  const std::vector<double>& depth = values_of(trace, "tool.depth_m");
  return !std::ranges::is_sorted(depth);
}

Figure force_over_depth(const Trace& trace) {
  const std::string caption =
      cuts(trace) ? "Resisting force along the needle over the depth of its tip; the tints are the "
                    "layers that the tip was in on its way in."
                  : "Resisting force over the depth of the tool below the undeformed skin.";
  return {
      .id = "force-over-depth",
      .title = "Force against depth",
      .caption = caption + (returns(trace) ? " Where the tool comes back the curve returns." : ""),
      .x = {.label = cuts(trace) ? "tip depth (mm)" : "depth (mm)"},
      .y = {.label = "force (N)"},
      .series = {{.x = values_of(trace, "tool.depth_m", mm),
                  .y = values_of(trace, "tool.force_n")}},
      .zones = cuts(trace) ? layers_over_depth(trace) : std::vector<Zone>{},
      .marks = events_over_depth(trace)};
}

Figure parts_over_depth(const Trace& trace) {
  const std::vector<std::size_t> rows = first_pass(trace);
  Figure figure{.id = "force-parts",
                .title = "Cutting, friction and stiffness",
                .caption =
                    "The three parts of the resisting force stacked on each other, on the way "
                    "in; the line is their sum.",
                .x = {.label = "tip depth (mm)"},
                .y = {.label = "force (N)"},
                .zones = layers_over_depth(trace)};
  const std::vector<double> depth = picked(values_of(trace, "tool.depth_m"), rows, mm);
  std::vector<double> floor(rows.size(), 0.0);
  for (const Part& part : parts) {
    std::vector<double> top = picked(values_of(trace, part.column), rows);
    for (std::size_t n = 0; n < top.size(); ++n) { top[n] += floor[n]; }
    figure.series.push_back(
        {.label = part.label, .style = Series::Style::area, .x = depth, .y = floor, .y2 = top});
    floor = std::move(top);
  }
  figure.series.push_back(
      {.label = "sum", .x = depth, .y = picked(values_of(trace, "tool.force_n"), rows)});
  return figure;
}

Figure force_over_time(const Trace& trace) {
  return {.id = "force-over-time",
          .title = "Force over time",
          .caption = "The same force at every tick.",
          .x = {.label = "time (s)"},
          .y = {.label = "force (N)"},
          .series = {{.x = trace.time, .y = values_of(trace, "tool.force_n")}},
          .marks = events_over_time(trace)};
}

Figure pressure_over_time(const Trace& trace) {
  return {
      .id = "pressure-over-time",
      .title = "Syringe pressure over time",
      .caption = "Gauge pressure behind the needle; the tints are the layers that the tip is in.",
      .x = {.label = "time (s)"},
      .y = {.label = "pressure (mmHg)"},
      .series = {{.x = trace.time,
                  .y = values_of(trace, "syringe.pressure_pa", 1.0 / pascals_per_mmhg)}},
      .zones = layers_over_time(trace),
      .marks = events_over_time(trace)};
}

Figure lateral_over_depth(const Trace& trace) {
  return {.id = "lateral-force",
          .title = "Lateral force against depth",
          .caption = "What the tissue presses sideways on the shaft.",
          .x = {.label = "tip depth (mm)"},
          .y = {.label = "lateral force (N)"},
          .series = {{.x = values_of(trace, "tool.depth_m", mm),
                      .y = values_of(trace, "tool.lateral_n")}},
          .zones = layers_over_depth(trace)};
}

}  // namespace

std::vector<Figure> tool_figures(const Trace& trace) {
  if (!has_tool(trace) || trace.time.size() < 2) { return {}; }
  std::vector<Figure> figures{force_over_depth(trace)};
  const bool needle = cuts(trace);
  if (needle) { figures.push_back(parts_over_depth(trace)); }
  figures.push_back(force_over_time(trace));
  if (trace.find("syringe.pressure_pa") != nullptr) {
    figures.push_back(pressure_over_time(trace));
  }
  if (needle && largest(trace, "tool.lateral_n") > least_lateral) {
    figures.push_back(lateral_over_depth(trace));
  }
  return figures;
}

std::vector<Figure> tool_traces(const Trace& trace) {
  if (!has_tool(trace) || trace.time.size() < 2) { return {}; }
  Figure force{
      .id = "tool-force",
      .title = "Force",
      .x = {.label = "time (s)"},
      .y = {.label = "force (N)"},
      .series = {{.label = "sum", .x = trace.time, .y = values_of(trace, "tool.force_n")}}};
  for (const Part& part : parts) {
    if (largest(trace, part.column) == 0.0) { continue; }
    force.series.push_back(
        {.label = part.label, .x = trace.time, .y = values_of(trace, part.column)});
  }
  std::vector<Figure> figures{std::move(force)};
  if (trace.find("syringe.pressure_pa") != nullptr) {
    Figure pressure = pressure_over_time(trace);
    pressure.id = "tool-pressure";
    pressure.title = "Syringe pressure";
    pressure.series.front().label = "pressure";
    figures.push_back(std::move(pressure));
  }
  return figures;
}

}  // namespace palpate
