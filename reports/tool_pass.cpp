// SPDX-License-Identifier: MIT
#include "reports/tool_pass.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "reports/shown_units.hpp"

namespace palpate {

namespace {

/// Stretches of equal label over a coordinate that rises with the rows; nameless ones are gaps.
std::vector<Zone> zones_of(const Trace& trace, const std::vector<std::size_t>& rows,
                           const std::vector<double>& coordinate, double scale) {
  std::vector<Zone> zones;
  std::string open;
  for (const std::size_t row : rows) {
    const std::string label = layer_in(trace, row);
    const double at = scale * coordinate[row];
    if (!open.empty()) { zones.back().end = at; }
    if (label != open && !label.empty()) { zones.push_back({label, at, at}); }
    open = label;
  }
  // A tip that rests on the skin is in it at one tick and above it at the next.
  constexpr double pixel = 1.0 / 400.0;
  const double span =
      rows.empty() ? 0.0 : scale * (coordinate[rows.back()] - coordinate[rows.front()]);
  std::erase_if(zones, [&](const Zone& zone) { return !(zone.end - zone.begin >= pixel * span); });
  return zones;
}

template <class Place>
std::vector<Mark> marks_of(const Trace& trace, Place&& place) {
  std::vector<Mark> marks;
  if (trace.time.empty()) { return marks; }
  for (const Event& event : trace.events) { marks.push_back({in_words(event.kind), place(event)}); }
  return marks;
}

}  // namespace

bool has_tool(const Trace& trace) {
  return trace.find("tool.depth_m") != nullptr && trace.find("tool.force_n") != nullptr;
}

bool is_tool_column(const std::string& name) {
  return name.starts_with("tool.") || name.starts_with("syringe.") || name.starts_with("device.");
}

const std::vector<double>& values_of(const Trace& trace, const std::string& name) {
  const Column* column = trace.find(name);
  if (column == nullptr) { throw std::out_of_range("the trace has no column " + name); }
  return column->values;
}

std::vector<double> values_of(const Trace& trace, const std::string& name, double factor) {
  std::vector<double> values = values_of(trace, name);
  for (double& value : values) { value *= factor; }
  return values;
}

std::vector<std::size_t> first_pass(const Trace& trace) {
  const std::vector<double>& depth = values_of(trace, "tool.depth_m");
  std::vector<std::size_t> rows;
  for (std::size_t n = 0; n < depth.size(); ++n) {
    if (!std::isfinite(depth[n])) { continue; }
    const bool still = rows.size() == 1 && depth[n] == depth[rows.front()];
    if (still) { rows.front() = n; }
    if (rows.empty() || depth[n] > depth[rows.back()]) { rows.push_back(n); }
  }
  return rows;
}

std::vector<Zone> layers_over_depth(const Trace& trace) {
  return zones_of(trace, first_pass(trace), values_of(trace, "tool.depth_m"), mm);
}

std::vector<Zone> layers_over_time(const Trace& trace) {
  std::vector<std::size_t> rows(trace.time.size());
  for (std::size_t n = 0; n < rows.size(); ++n) { rows[n] = n; }
  return zones_of(trace, rows, trace.time, 1.0);
}

std::size_t row_at(const Trace& trace, double time) {
  // An event carries the sum of its steps, which may round above its tick.
  const double slack = 1e-9 * std::max(1.0, std::abs(time));
  const auto row = std::ranges::lower_bound(trace.time, time - slack);
  const auto last = static_cast<std::ptrdiff_t>(trace.time.size()) - 1;
  return static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(row - trace.time.begin(), 0, last));
}

std::vector<Mark> events_over_depth(const Trace& trace) {
  const std::vector<double>& depth = values_of(trace, "tool.depth_m");
  return marks_of(trace, [&](const Event& event) { return mm * depth[row_at(trace, event.time)]; });
}

std::vector<Mark> events_over_time(const Trace& trace) {
  return marks_of(trace, [](const Event& event) { return event.time; });
}

std::string layer_in(const Trace& trace, std::size_t row) {
  for (const TextColumn& column : trace.text_columns) {
    if (column.name == "tool.layer" && row < column.values.size()) { return column.values[row]; }
  }
  return {};
}

std::string in_words(std::string kind) {
  std::ranges::replace(kind, '-', ' ');
  return kind;
}

}  // namespace palpate
