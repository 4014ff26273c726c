// SPDX-License-Identifier: MIT
#include "reports/falcon_report.hpp"

#include <string>

#include "reports/markup.hpp"
#include "reports/tool_pass.hpp"

namespace palpate {

namespace {

constexpr double mm = 1e3;
constexpr double mj = 1e3;

std::string with(double value, const char* unit) { return short_number(value) + " " + unit; }

std::vector<double> scaled(const std::vector<double>& values, double factor) {
  std::vector<double> out(values);
  for (double& value : out) { value *= factor; }
  return out;
}

}  // namespace

std::vector<Figure> falcon_figures(const Trace& trace) {
  if (trace.find("device.requested_n") == nullptr || trace.time.size() < 2) { return {}; }
  Figure force{.id = "device-force",
               .title = "Force asked of the device, and delivered",
               .caption = "Magnitudes on the hand at every tick: what the rendering asked for and "
                          "what the motors pulled with.",
               .x = {.label = "time (s)"},
               .y = {.label = "force (N)"},
               .marks = events_over_time(trace)};
  force.series.push_back({.label = "delivered",
                          .x = trace.time,
                          .y = values_of(trace, "device.delivered_n")});
  force.series.push_back({.label = "asked for",
                          .style = Series::Style::dashed,
                          .x = trace.time,
                          .y = values_of(trace, "device.requested_n")});
  Figure way{.id = "hand-and-tip",
             .title = "What the hand wants, and where the tip is",
             .caption = "Along the needle's line; the gap is what the hand's spring and the "
                        "coupling are stretched by.",
             .x = {.label = "time (s)"},
             .y = {.label = "place (mm)"},
             .zones = layers_over_time(trace),
             .marks = events_over_time(trace)};
  way.series.push_back({.label = "intent",
                        .style = Series::Style::dashed,
                        .x = trace.time,
                        .y = scaled(values_of(trace, "device.intent_m"), mm)});
  way.series.push_back(
      {.label = "tip", .x = trace.time, .y = scaled(values_of(trace, "tool.insertion_m"), mm)});
  Figure energy{.id = "port-energy",
                .title = "Energy that the hand put in",
                .caption = "Through the device's port, as positions that were read and forces that "
                           "were asked for tell it; below zero the rendering feeds energy in.",
                .x = {.label = "time (s)"},
                .y = {.label = "energy (mJ)"},
                .series = {{.x = trace.time, .y = scaled(values_of(trace, "device.energy_j"), mj)}}};
  return {std::move(force), std::move(way), std::move(energy)};
}

std::vector<Fact> falcon_fact_list(const FalconFacts& facts) {
  const double share =
      facts.ticks > 0 ? static_cast<double>(facts.saturated) / static_cast<double>(facts.ticks) : 0.0;
  std::vector<Fact> list{
      {"force on the hand", with(facts.largest_delivered, "N"),
       "at most; asked for " + with(facts.largest_requested, "N")},
      {"motors at their limit", with(100.0 * share, "%"),
       "of the ticks; in reach at the start " + with(facts.axial_force, "N") +
           " against the insertion, " + with(facts.weakest_force, "N") + " in every direction"},
      {"energy at the port", with(mj * facts.least_energy, "mJ"),
       facts.least_energy < 0.0 ? "at least, at " + with(facts.least_energy_at, "s") +
                                      ": the rendering fed in as much"
                                : "at least: the rendering was passive"}};
  if (facts.taken_by_controller > 0.0) {
    list.push_back({"taken by the controller", with(mj * facts.taken_by_controller, "mJ"), ""});
  }
  if (facts.lost_resistance_at) {
    list.push_back({"overshoot", with(mm * facts.overshoot, "mm"),
                    "of the tip beyond the loss of resistance at " +
                        with(*facts.lost_resistance_at, "s") + ", felt " +
                        with(1e3 * facts.reaction, "ms") + " later"});
  }
  if (facts.unanswered > 0) {
    list.push_back({"requests without reply", std::to_string(facts.unanswered), ""});
  }
  return list;
}

}  // namespace palpate
