// SPDX-License-Identifier: MIT
#include "validation/cases/errata_pressed.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::errata {

namespace {

constexpr double never = std::numeric_limits<double>::infinity();
constexpr long ticks = 500;  ///< steps of 1e-4 s

/// The samples until the printed form is off by the whole peak, and when that is.
struct Departure {
  double error = 0.0;
  double at = never;
};

Departure departure(const Pressed& run, const Eigen::MatrixXd& truth) {
  const double peak = truth.cwiseAbs().maxCoeff();
  Departure found;
  for (Eigen::Index n = 0; n < run.displacement.cols(); ++n) {
    const double error = (run.displacement.col(n) - truth.col(n)).cwiseAbs().maxCoeff() / peak;
    found.error = std::max(found.error, error);
    if (!(error < 1.0) && found.at == never) { found.at = run.time[static_cast<std::size_t>(n)]; }
  }
  if (run.diverged) {
    found.error = never;
    found.at = std::min(found.at, run.diverged_at);
  }
  return found;
}

/// Depth of the pressed node in millimetres, as far as it stays in the picture.
Series depth(const std::string& label, Series::Style style, const std::vector<double>& time,
             const Eigen::MatrixXd& displacement, double bound) {
  Series series{.label = label, .style = style};
  for (Eigen::Index n = 0; n < displacement.cols(); ++n) {
    const double z = displacement(3 * pressed_node + 2, n);
    if (!(std::abs(z) <= bound)) { break; }
    series.x.push_back(1e3 * time[static_cast<std::size_t>(n)]);
    series.y.push_back(1e3 * z);
  }
  return series;
}

Cell finite_or(const std::string& words, double value) {
  return std::isfinite(value) ? Cell(value) : Cell(words);
}

/// First order: the error is twice its change when the step is halved.
double judge_corrected(const CaseContext& context, Outcome& outcome, const Pressed& coarse,
                       const Eigen::MatrixXd& truth) {
  const Pressed fine = run_pressed(context, {}, 2 * ticks);
  const double expected = 2.0 * distance(fine.displacement, coarse.displacement);
  const double error = distance(coarse.displacement, truth);
  outcome.judge(
      {.name = "corrected model against ARKODE",
       .value = error,
       .lower = 0.85 * expected,
       .upper = 1.15 * expected,
       .bound_from = "twice the change on halving the step (order 1), +-15 % of order 2"});
  return error;
}

}  // namespace

void compare_pressed(const CaseContext& context, Outcome& outcome, const PrintedForm& printed,
                     const std::string& name) {
  const std::vector<double> times = pressed_times();
  const Eigen::MatrixXd truth = solve_pressed(times, {});
  const Pressed coarse = run_pressed(context, {}, ticks);
  const Pressed wrong = run_pressed(context, printed, ticks);
  const double error = judge_corrected(context, outcome, coarse, truth);
  const Departure off = departure(wrong, truth);
  outcome.tables.push_back(
      {.id = "errors",
       .title = "A pressed lattice, corrected and as printed: " + name,
       .caption = "Same scheme (Euler-Cromer) and step (0.1 ms); errors over 50 ms against ARKODE.",
       .columns = {"form", "error over peak (1)", "off by the whole peak at (s)"},
       .rows = {
           {"corrected", error, "never"},
           {"as printed: " + name, finite_or("diverged", off.error), finite_or("never", off.at)}}});
  const double bound = 3.0 * truth.cwiseAbs().maxCoeff();
  outcome.figures.push_back(
      {.id = "pressed",
       .title = "Depth of a pressed node: " + name,
       .caption =
           "The corrected model lies on the reference; beside it what the printed form does, "
           "as far as three times the peak.",
       .x = {.label = "time (ms)"},
       .y = {.label = "depth (mm)"},
       .series = {
           depth("ARKODE", Series::Style::line, times, truth, never),
           depth("corrected", Series::Style::points, coarse.time, coarse.displacement, never),
           depth("as printed", Series::Style::line_and_points, wrong.time, wrong.displacement,
                 bound)}});
}

}  // namespace palpate::errata
