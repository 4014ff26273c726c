// SPDX-License-Identifier: MIT

#include "reports/plot/trace_figures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>

#include "model/problem/recording.hpp"

namespace palpate {
namespace {

/// Zones of equal label over an increasing coordinate; rows without a label are gaps.
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
  // The tip of a tool at rest on the skin can alternate between inside and outside at each tick.
  constexpr double pixel = 1.0 / 400.0;
  const double span =
      rows.empty() ? 0.0 : scale * (coordinate[rows.back()] - coordinate[rows.front()]);
  std::erase_if(zones, [&](const Zone& zone) { return !(zone.end - zone.begin >= pixel * span); });
  return zones;
}

/// Events over time, or over the depth of the tip.
std::vector<Mark> events_over(const Trace& trace, Over over) {
  std::vector<Mark> marks;
  for (const Event& event : trace.events) {
    if (trace.time.empty()) { break; }
    const double at = over == Over::time
                          ? event.time
                          : mm * values_of(trace, "tool.depth_m")[row_at(trace, event.time)];
    marks.push_back({in_words(event.kind), at});
  }
  return marks;
}

constexpr double settling = 0.1;  // maximum duration of a loss of resistance [s]

constexpr double least_depth = 1e-12;  // rounding level of depths [m]

std::string where(const Trace& trace, std::size_t row) {
  const std::string layer = layer_in(trace, row);
  return (layer.empty() ? "" : "in " + layer + ", ") + "at " + quantity(trace.time[row], "s");
}

std::string depth_of(const Trace& trace, std::size_t row) {
  return quantity(mm * values_of(trace, "tool.depth_m")[row], "mm");
}

/// Row of the largest finite value; nothing if no value is positive.
std::optional<std::size_t> peak_of(const std::vector<double>& values) {
  std::optional<std::size_t> peak;
  for (std::size_t n = 0; n < values.size(); ++n) {
    if (values[n] > (peak ? values[*peak] : 0.0) && std::isfinite(values[n])) { peak = n; }
  }
  return peak;
}

Fact peak_force(const Trace& trace) {
  const std::vector<double>& force = values_of(trace, "tool.force_n");
  const auto peak = peak_of(force);
  if (!peak) { return {"peak force", "none", "nothing resisted the tool"}; }
  return {"peak force", quantity(force[*peak], "N"),
          depth_of(trace, *peak) + " deep " + where(trace, *peak)};
}

Fact deepest(const Trace& trace) {
  const auto peak = peak_of(values_of(trace, "tool.depth_m"));
  if (!peak) { return {"deepest place", "none", "the tool did not enter"}; }
  return {"deepest place", depth_of(trace, *peak), where(trace, *peak)};
}

/// From one tick before the event to the minimum force shortly after it.
Fact loss_of_resistance(const Trace& trace, const Event& event) {
  const std::vector<double>& force = values_of(trace, "tool.force_n");
  const std::size_t row = row_at(trace, event.time);
  const double before = force[row > 0 ? row - 1 : 0];
  double after = force[row];
  for (std::size_t n = row; n < force.size() && trace.time[n] <= event.time + settling; ++n) {
    after = std::min(after, force[n]);
  }
  return {"loss of resistance", depth_of(trace, row),
          "at " + quantity(event.time, "s") + "; the force falls by " +
              quantity(before - after, "N") + ", from " + quantity(before, "N") + " to " +
              quantity(after, "N") + " within " + quantity(settling, "s")};
}

void add_pressure(std::vector<Fact>& facts, const Trace& trace) {
  if (trace.find("syringe.pressure_pa") == nullptr) { return; }
  const std::vector<double>& pressure = values_of(trace, "syringe.pressure_pa");
  const auto peak = peak_of(pressure);
  if (!peak) { return; }
  facts.push_back(
      {"peak pressure", quantity(pressure[*peak] / pascals_per_mmhg, "mmHg"),
       quantity(1e-3 * pressure[*peak], "kPa") + ", first reached " + where(trace, *peak)});
}

constexpr double least_lateral = 1e-6;  // rounding level of lateral forces [N]

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

/// Returns true for a tool with a shaft and an edge; a probe has neither.
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
  Figure figure =
      figure_over(trace, Over::depth, "force-over-depth", "Force against depth",
                  caption + (returns(trace) ? " Where the tool comes back the curve returns." : ""),
                  "force (N)");
  add_column(figure, trace, Over::depth, "tool.force_n");
  if (!cuts(trace)) {
    figure.x.label = "depth (mm)";
    figure.zones.clear();
  }
  return figure;
}

Figure parts_over_depth(const Trace& trace) {
  const std::vector<std::size_t> rows = first_pass(trace);
  Figure figure = figure_over(trace, Over::depth, "force-parts", "Cutting, friction and stiffness",
                              "The three parts of the resisting force stacked on each other, on "
                              "the way in; the line is their sum.",
                              "force (N)");
  figure.marks.clear();
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

/// Returns the force over time. With a syringe the figure also has the force of the thumb and the
/// depth, as the paper's Fig. 22.
Figure force_over_time(const Trace& trace) {
  if (trace.find("syringe.thumb_n") == nullptr) {
    Figure figure = figure_over(trace, Over::time, "force-over-time", "Force over time",
                                "The same force at every tick.", "force (N)");
    add_column(figure, trace, Over::time, "tool.force_n");
    figure.zones.clear();
    return figure;
  }
  Figure figure = figure_over(trace, Over::time, "force-over-time", "Applied force and reaction",
                              "Force of the thumb on the plunger (pressure times area, plus the "
                              "friction of the plunger), reaction of the tissue on the needle, "
                              "and depth of the tip.",
                              "force (N), depth (cm)");
  add_column(figure, trace, Over::time, "tool.force_n", "reaction");
  add_column(figure, trace, Over::time, "syringe.thumb_n", "thumb on the plunger");
  add_column(figure, trace, Over::time, "tool.depth_m", "depth (cm)", 100.0);
  figure.zones.clear();
  return figure;
}

Figure pressure_over_time(const Trace& trace, const std::string& label = "") {
  Figure figure =
      figure_over(trace, Over::time, "pressure-over-time", "Syringe pressure over time",
                  "Gauge pressure behind the needle; the tints are the layers that the tip is in.",
                  "pressure (mmHg)");
  add_column(figure, trace, Over::time, "syringe.pressure_pa", label, 1.0 / pascals_per_mmhg);
  return figure;
}

Figure lateral_over_depth(const Trace& trace) {
  Figure figure =
      figure_over(trace, Over::depth, "lateral-force", "Lateral force against depth",
                  "What the tissue presses sideways on the shaft.", "lateral force (N)");
  add_column(figure, trace, Over::depth, "tool.lateral_n");
  figure.marks.clear();
  return figure;
}

/// Adjacent columns that are drawn in one figure.
struct Group {
  std::string record;
  std::string unit;
  std::vector<const Column*> columns;
};

/// Record and quantity of a column: "tip" and "vx" for "tip.vx_m_per_s".
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
    if (column.name.starts_with("tool.") || column.name.starts_with("syringe.") ||
        column.name.starts_with("device.")) {
      continue;
    }
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

/// Rows that a curve keeps: of a long trace the smallest and largest of each of many parts, and its
/// gaps, so that a page of a long run needs little memory and its picture does not change.
std::vector<std::size_t> rows_of_curve(const std::vector<double>& values) {
  constexpr std::size_t part_count = 10'000;  // several for each pixel
  std::vector<std::size_t> rows;
  if (values.size() <= 4 * part_count) {
    rows.resize(values.size());
    std::iota(rows.begin(), rows.end(), std::size_t{0});
    return rows;
  }
  for (std::size_t part = 0; part < part_count; ++part) {
    const std::size_t begin = part * values.size() / part_count;
    const std::size_t end = (part + 1) * values.size() / part_count;
    std::optional<std::size_t> gap, least, largest;
    for (std::size_t n = begin; n < end; ++n) {
      if (!std::isfinite(values[n])) {
        gap = gap.value_or(n);
        continue;
      }
      if (!least || values[n] < values[*least]) { least = n; }
      if (!largest || values[n] > values[*largest]) { largest = n; }
    }
    std::set<std::size_t> kept{part == 0 ? begin : end - 1};
    for (const auto& row : {gap, least, largest}) {
      if (row) { kept.insert(*row); }
    }
    rows.insert(rows.end(), kept.begin(), kept.end());
  }
  return rows;
}

Figure figure_of(const Group& group, const Trace& trace, std::size_t index) {
  const std::string subject = subject_of(group);
  Figure figure{
      .id = "trace-" + std::to_string(index),
      .title = group.record.empty() ? subject : group.record + ": " + subject,
      .caption = as_displacement(group) ? "Displacement from the first tick." : "At every tick.",
      .x = {.label = "time (s)"},
      .y = {.label = subject + " (" + group.unit + ")"}};
  if (group.columns.front()->name == "tissue.smallest_jacobian") {
    figure.title = "Smallest cell of the tissue";
    figure.caption =
        "Smallest volume of a cell's corner over that at rest, at the last of 200 checks.";
    figure.y.label = "volume over rest (1)";
  }
  for (const Column* column : group.columns) {
    const std::vector<std::size_t> rows = rows_of_curve(column->values);
    Series series{.label = short_name(*column),
                  .x = picked(trace.time, rows, 1.0),
                  .y = picked(column->values, rows, 1.0)};
    if (as_displacement(group)) {
      for (double& y : series.y) { y -= column->values.front(); }
    }
    figure.series.push_back(std::move(series));
  }
  return figure;
}

}  // namespace

Figure figure_over(const Trace& trace, Over over, const std::string& id, const std::string& title,
                   const std::string& caption, const std::string& y_label) {
  const bool time = over == Over::time;
  return {.id = id,
          .title = title,
          .caption = caption,
          .x = {.label = time ? "time (s)" : "tip depth (mm)"},
          .y = {.label = y_label},
          .zones = time ? layers_over_time(trace) : layers_over_depth(trace),
          .marks = events_over(trace, over)};
}

void add_column(Figure& figure, const Trace& trace, Over over, const std::string& column,
                const std::string& label, double factor, Series::Style style) {
  if (trace.find(column) == nullptr) { return; }
  const std::vector<double>& values = values_of(trace, column);
  const std::vector<std::size_t> rows = rows_of_curve(values);
  const bool time = over == Over::time;
  figure.series.push_back(
      {.label = label,
       .style = style,
       .x = picked(time ? trace.time : values_of(trace, "tool.depth_m"), rows, time ? 1.0 : mm),
       .y = picked(values, rows, factor)});
}

bool has_tool(const Trace& trace) {
  return trace.find("tool.depth_m") != nullptr && trace.find("tool.force_n") != nullptr;
}

const std::vector<double>& values_of(const Trace& trace, const std::string& name) {
  const Column* column = trace.find(name);
  if (column == nullptr) { throw std::out_of_range("the trace has no column " + name); }
  return column->values;
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
  // An event time is a sum of steps, which can round to above its tick.
  const double slack = 1e-9 * std::max(1.0, std::abs(time));
  const auto row = std::ranges::lower_bound(trace.time, time - slack);
  const auto last = static_cast<std::ptrdiff_t>(trace.time.size()) - 1;
  return static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(row - trace.time.begin(), 0, last));
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

std::vector<Fact> tool_facts(const Trace& trace) {
  if (!has_tool(trace) || trace.time.empty()) { return {}; }
  std::vector<Fact> facts{peak_force(trace), deepest(trace)};
  for (const Event& event : trace.events) {
    if (event.kind != "loss-of-resistance") { continue; }
    facts.push_back(loss_of_resistance(trace, event));
    break;  // only the first; the table of events contains all
  }
  add_pressure(facts, trace);
  return facts;
}

Table events_table(const Trace& trace) {
  Table table{.title = "In order of time"};
  if (!has_tool(trace) || trace.time.empty()) {
    table.columns = {"time (s)", "event", "detail"};
    for (const Event& event : trace.events) {
      table.rows.push_back({event.time, event.kind, event.detail});
    }
    return table;
  }
  table.caption = "Forces of the tick before the event and of its own.";
  table.columns = {"time (s)", "event", "layer", "depth (mm)", "force before (N)", "force (N)"};
  const std::vector<double>& depth = values_of(trace, "tool.depth_m");
  const std::vector<double>& force = values_of(trace, "tool.force_n");
  for (const Event& event : trace.events) {
    const std::size_t row = row_at(trace, event.time);
    const double deep = std::abs(depth[row]) < least_depth ? 0.0 : mm * depth[row];
    table.rows.push_back({event.time, in_words(event.kind), event.detail, deep,
                          force[row > 0 ? row - 1 : 0], force[row]});
  }
  return table;
}

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
  std::vector<Figure> figures{
      figure_over(trace, Over::time, "tool-force", "Force", "", "force (N)")};
  add_column(figures[0], trace, Over::time, "tool.force_n", "sum");
  for (const Part& part : parts) {
    if (largest(trace, part.column) == 0.0) { continue; }
    add_column(figures[0], trace, Over::time, part.column, part.label);
  }
  if (trace.find("syringe.pressure_pa") != nullptr) {
    figures.push_back(pressure_over_time(trace, "pressure"));
    figures.back().id = "tool-pressure";
    figures.back().title = "Syringe pressure";
  }
  return figures;
}

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

}  // namespace palpate
