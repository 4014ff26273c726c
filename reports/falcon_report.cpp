// SPDX-License-Identifier: MIT
#include "reports/falcon_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "reports/markup.hpp"
#include "reports/shown_units.hpp"
#include "reports/tool_pass.hpp"

namespace palpate {

namespace {

using Point = std::array<double, 2>;

/// Left of the way from a to b, seen along it.
bool is_left(const Point& a, const Point& b, const Point& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) > (b[1] - a[1]) * (c[0] - a[0]);
}

/// Outline of points, closed (Andrew's monotone chain).
std::vector<Point> outline(std::vector<Point> points) {
  std::ranges::sort(points);
  std::vector<Point> hull;
  const auto walk = [&](auto first, auto last) {
    const std::size_t kept = hull.size();
    for (auto it = first; it != last; ++it) {
      while (hull.size() >= kept + 2 && !is_left(hull[hull.size() - 2], hull.back(), *it)) {
        hull.pop_back();
      }
      hull.push_back(*it);
    }
    hull.pop_back();
  };
  walk(points.begin(), points.end());
  walk(points.rbegin(), points.rend());
  hull.push_back(hull.front());
  return hull;
}

Series circle(const std::string& label, double radius, Series::Style style) {
  Series series{.label = label, .style = style};
  constexpr int corners = 120;
  for (int n = 0; n <= corners; ++n) {
    const double angle = 2.0 * std::numbers::pi * n / corners;
    series.x.push_back(radius * std::cos(angle));
    series.y.push_back(radius * std::sin(angle));
  }
  return series;
}

/// The paper's figure for its device, Vaughan et al. [N].
constexpr double stated_by_the_paper = 15.0;

}  // namespace

Figure force_reach_figure(const FalconFacts& facts) {
  const double reach = 10.0 * std::ceil(std::max(facts.axial_force, stated_by_the_paper) / 10.0);
  Figure figure{.id = "force-reach",
                .title = "What the motors can pull the hand with",
                .caption = "Outlines of all forces within the torques of the motors at the grip's "
                           "place on the skin, seen from two sides: much along the needle, little in the "
                           "weakest direction. Up is out of the tissue, against the insertion.",
                .x = {.label = "force across the needle (N)", .minimum = -reach, .maximum = reach},
                .y = {.label = "force along the needle, outward (N)", .minimum = -reach, .maximum = reach},
                .square = true};
  const char* names[] = {"left and right", "up and down"};
  for (const int axis : {0, 1}) {
    std::vector<Point> points;
    for (const Eigen::Vector3d& corner : facts.force_corners) {
      points.push_back({corner(axis), corner.z()});
    }
    Series series{.label = names[axis]};
    for (const Point& point : outline(std::move(points))) {
      series.x.push_back(point[0]);
      series.y.push_back(point[1]);
    }
    figure.series.push_back(std::move(series));
  }
  figure.series.push_back(circle("in every direction", facts.weakest_force, Series::Style::line));
  figure.series.push_back(circle("stated in the paper", stated_by_the_paper, Series::Style::dashed));
  return figure;
}

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
                        .y = values_of(trace, "device.intent_m", mm)});
  way.series.push_back(
      {.label = "tip", .x = trace.time, .y = values_of(trace, "tool.insertion_m", mm)});
  Figure energy{.id = "port-energy",
                .title = "Energy that the hand put in",
                .caption = "Through the device's port, as positions that were read and forces that "
                           "were asked for tell it; below zero the rendering feeds energy in.",
                .x = {.label = "time (s)"},
                .y = {.label = "energy (mJ)"},
                .series = {{.x = trace.time, .y = values_of(trace, "device.energy_j", mj)}}};
  return {std::move(force), std::move(way), std::move(energy)};
}

std::vector<Fact> falcon_fact_list(const FalconFacts& facts) {
  const double share =
      facts.ticks > 0 ? static_cast<double>(facts.saturated) / static_cast<double>(facts.ticks) : 0.0;
  std::vector<Fact> list{
      {"force on the hand", quantity(facts.largest_delivered, "N"),
       "at most; asked for " + quantity(facts.largest_requested, "N")},
      {"motors at their limit", quantity(100.0 * share, "%"),
       "of the ticks; in reach at the start " + quantity(facts.axial_force, "N") +
           " against the insertion, " + quantity(facts.weakest_force, "N") + " in every direction"},
      {"energy at the port", quantity(mj * facts.least_energy, "mJ"),
       facts.least_energy < 0.0 ? "at least, at " + quantity(facts.least_energy_at, "s") +
                                      ": the rendering fed in as much"
                                : "at least: the rendering was passive"}};
  if (facts.taken_by_controller > 0.0) {
    list.push_back({"taken by the controller", quantity(mj * facts.taken_by_controller, "mJ"), ""});
  }
  if (facts.lost_resistance_at) {
    list.push_back({"overshoot", quantity(mm * facts.overshoot, "mm"),
                    "of the tip beyond the loss of resistance at " +
                        quantity(*facts.lost_resistance_at, "s") + ", felt " +
                        quantity(1e3 * facts.reaction, "ms") + " later"});
  }
  if (facts.unanswered > 0) {
    list.push_back({"requests without reply", std::to_string(facts.unanswered), ""});
  }
  if (facts.unhomed > 0) {
    list.push_back({"ticks without a place", std::to_string(facts.unhomed),
                    "the device had lost its zero; no force was asked for"});
  }
  return list;
}

}  // namespace palpate
