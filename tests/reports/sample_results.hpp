// SPDX-License-Identifier: MIT
#pragma once
/// Sample results that contain every element of a report.

#include <cmath>

#include "reports/results/results.hpp"

namespace sample {

using namespace palpate;

inline Figure curve() {
  Figure figure{.id = "error-over-step",
                .title = "Error <over> step & \"more\"",
                .caption = "The error falls with the square of the step.",
                .x = {.label = "step (s)", .logarithmic = true},
                .y = {.label = "error (1)", .logarithmic = true}};
  figure.series = {
      {.label = "measured_error^2", .style = Series::Style::line_and_points},
      {.label = "floor", .style = Series::Style::dashed},
      {.label = "band",
       .style = Series::Style::band,
       .x = {0.01, 1.0},
       .y = {1e-5, 1e-3},
       .y2 = {1e-4, 1e-2}},
  };
  for (int n = 0; n < 8; ++n) {
    const double h = std::pow(0.5, n);
    for (std::size_t s : {0U, 1U}) { figure.series[s].x.push_back(h); }
    figure.series[0].y.push_back(n == 3 ? std::nan("") : h * h);
    figure.series[1].y.push_back(1e-6);
  }
  return figure;
}

inline Figure map() {
  Figure figure{.id = "map",
                .title = "Growth",
                .caption = "Where a step amplifies.",
                .x = {.label = "h omega (1)"},
                .y = {.label = "damping ratio (1)"}};
  HeatMap& heat = figure.heat_map.emplace();
  heat.label = "log10 growth (1)";
  for (int row = 0; row < 12; ++row) {
    heat.x.push_back(0.25 * row);
    heat.y.push_back(0.1 * row);
    for (int column = 0; column < 12; ++column) { heat.z.push_back(std::sin(0.4 * row) * column); }
  }
  figure.series = {{.label = "theory", .x = {0.0, 2.75}, .y = {1.1, 0.0}}};
  return figure;
}

/// Two components stacked over depth with their sum, three layers, and marks at the layer borders.
inline Figure layered() {
  Figure figure{.id = "parts",
                .title = "Parts of a force",
                .caption = "Stacked.",
                .x = {.label = "depth (mm)"},
                .y = {.label = "force (N)"}};
  Series lower{.label = "friction", .style = Series::Style::area};
  Series upper{.label = "cutting", .style = Series::Style::area};
  Series sum{.label = "sum"};
  for (int n = 0; n <= 40; ++n) {
    const double depth = 0.25 * n;
    for (Series* series : {&lower, &upper, &sum}) { series->x.push_back(depth); }
    lower.y.push_back(0.0);
    lower.y2.push_back(0.3 * depth);
    upper.y.push_back(0.3 * depth);
    upper.y2.push_back(0.3 * depth + 2.0);
    sum.y.push_back(0.3 * depth + 2.0);
  }
  figure.series = {lower, upper, sum};
  figure.zones = {{"skin <1>", 0.0, 2.0}, {"ligamentum flavum", 2.0, 9.0}, {"dura", 9.0, 10.0}};
  figure.marks = {{"contact", 0.0}, {"puncture & more", 2.0}, {"puncture & more", 9.0}};
  return figure;
}

inline Quantity bounded(const char* name, double value, const char* unit, double lower,
                        double upper) {
  return {.name = name,
          .value = value,
          .unit = unit,
          .lower = lower,
          .upper = upper,
          .bound_from = "theory"};
}

inline Results results() {
  Outcome good{.name = "oscillator/order/rk4",
               .suite = "accuracy",
               .claim = "rk4 converges at order 4",
               .seconds = 0.25};
  good.judge(bounded("observed_order", 4.01, "1", 3.85, 4.15));
  good.judge(
      {.name = "error", .value = 1e-9, .unit = "m", .upper = 1e-8, .bound_from = "round-off"});
  good.judge({.name = "rungs", .value = 6.0});
  good.figures = {curve(), map(), layered()};
  good.tables = {
      {.id = "errors",
       .title = "Errors",
       .caption = "At three steps.",
       .columns = {"scheme", "error (m)"},
       .rows = {{std::string("rk4 <fast>"), 1.23456789e-9}, {std::string("euler"), std::nan("")}}}};
  good.timings = {{.name = "rk4", .value = 0.5}};
  good.notes = {"a note with & and <tags>"};
  conclude(good);
  Outcome bad{.name = "network/patch-test",
              .suite = "accuracy",
              .claim = "a block has the modulus that it was built from"};
  bad.judge(bounded("modulus", std::nan(""), "Pa", 1.0, 2.0));
  conclude(bad);
  Outcome skipped{
      .name = "patient/lumbar", .suite = "accuracy", .claim = "a network moves as its references"};
  skipped.skip("the folder lumbar_network is absent");
  Outcome broken{.name = "stability/drift",
                 .suite = "stability",
                 .claim = "energy does not drift",
                 .status = Status::error,
                 .reasons = {"solver: flag -4"}};
  return {.title = "Palpate <validation>",
          .command = "palpate validate",
          .provenance = {{"version", "0.1.0"}, {"date", "today"}},
          .outcomes = {good, bad, skipped, broken}};
}

}  // namespace sample
