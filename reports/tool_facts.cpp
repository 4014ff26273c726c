// SPDX-License-Identifier: MIT
#include "reports/tool_facts.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "model/dynamics/pressure_units.hpp"
#include "reports/markup.hpp"
#include "reports/shown_units.hpp"
#include "reports/tool_pass.hpp"

namespace palpate {

namespace {

constexpr double settling = 0.1;  // [s] in which a loss of resistance is over

constexpr double least_depth = 1e-12;  // [m] below it there is only rounding

std::string where(const Trace& trace, std::size_t row) {
  const std::string layer = layer_in(trace, row);
  return (layer.empty() ? "" : "in " + layer + ", ") + "at " + quantity(trace.time[row], "s");
}

std::string depth_of(const Trace& trace, std::size_t row) {
  return quantity(mm * values_of(trace, "tool.depth_m")[row], "mm");
}

/// Row of the largest finite value; nothing when there is none above zero.
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

/// From one tick before the event to the lowest force soon after it.
Fact loss_of_resistance(const Trace& trace, const Event& event) {
  const std::vector<double>& force = values_of(trace, "tool.force_n");
  const std::size_t row = row_at(trace, event.time);
  const double before = force[row > 0 ? row - 1 : 0];
  double after = force[row];
  for (std::size_t n = row; n < force.size() && trace.time[n] <= event.time + settling; ++n) {
    after = std::min(after, force[n]);
  }
  return {"loss of resistance", depth_of(trace, row),
          "at " + quantity(event.time, "s") + "; the force falls by " + quantity(before - after, "N") +
              ", from " + quantity(before, "N") + " to " + quantity(after, "N") + " within " +
              quantity(settling, "s")};
}

void add_pressure(std::vector<Fact>& facts, const Trace& trace) {
  if (trace.find("syringe.pressure_pa") == nullptr) { return; }
  const std::vector<double>& pressure = values_of(trace, "syringe.pressure_pa");
  const auto peak = peak_of(pressure);
  if (!peak) { return; }
  facts.push_back({"peak pressure", quantity(pressure[*peak] / pascals_per_mmhg, "mmHg"),
                   quantity(1e-3 * pressure[*peak], "kPa") + ", first reached " + where(trace, *peak)});
}

}  // namespace

std::vector<Fact> tool_facts(const Trace& trace) {
  if (!has_tool(trace) || trace.time.empty()) { return {}; }
  std::vector<Fact> facts{peak_force(trace), deepest(trace)};
  for (const Event& event : trace.events) {
    if (event.kind != "loss-of-resistance") { continue; }
    facts.push_back(loss_of_resistance(trace, event));
    break;  // the first; the table of events has them all
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

}  // namespace palpate
