// SPDX-License-Identifier: MIT
/// The paper's Figs. 6 to 9 with its own parameters, each judged by numbers that theory gives.

#include <cmath>
#include <limits>
#include <numbers>

#include "validation/cases/oscillator_parts.hpp"
#include "validation/cases/oscillator_setting.hpp"

namespace palpate::oscillator {

namespace {

constexpr double amplitude = 3.0;  ///< A [m] of Fig. 6
constexpr double epsilon = std::numeric_limits<double>::epsilon();

using Curve = std::function<double(double)>;

/// Zeros of a curve on [0, 25] s, to rounding.
std::vector<double> zeros_of(const Curve& curve) {
  std::vector<double> zeros;
  const double spacing = 0.01;
  for (int n = 0; n < 2500; ++n) {
    double low = spacing * n;
    double high = spacing * (n + 1);
    if (!(curve(low) * curve(high) < 0.0)) { continue; }
    const bool falls = curve(low) > 0.0;
    for (int halving = 0; halving < 60; ++halving) {
      const double middle = 0.5 * (low + high);
      ((curve(middle) > 0.0) == falls ? low : high) = middle;
    }
    zeros.push_back(0.5 * (low + high));
  }
  return zeros;
}

/// [rad/s] from the first and last zero; NaN with fewer than two.
double frequency_of(const std::vector<double>& zeros) {
  if (zeros.size() < 2) { return std::numeric_limits<double>::quiet_NaN(); }
  return std::numbers::pi * static_cast<double>(zeros.size() - 1) / (zeros.back() - zeros.front());
}

/// Central differences with h and h/2, extrapolated: error of order h^4.
double slope_at_zero(const Curve& curve) {
  const auto slope = [&](double h) { return (curve(h) - curve(-h)) / (2.0 * h); };
  return (4.0 * slope(0.5e-3) - slope(1e-3)) / 3.0;
}

void judge_near(Outcome& outcome, const std::string& name, double value, const std::string& unit,
                double expected, double tolerance, const std::string& from) {
  outcome.judge({.name = name,
                 .value = value,
                 .unit = unit,
                 .lower = expected - tolerance,
                 .upper = expected + tolerance,
                 .bound_from = from});
}

void judge_forms(Outcome& outcome, double c, Table& table) {
  Oscillator o = paper_oscillator(c);
  o.displacement = amplitude;
  const Curve printed = [o](double t) { return equation_6_printed(o, amplitude, t); };
  const Curve plotted = [o](double t) { return equation_6_plotted(o, amplitude, 0.0, t); };
  const Curve exact = [o](double t) { return exact_motion(o, t).position; };
  const std::string label = ", c = " + text(c);
  const double omega1 = std::sqrt(1.0 - 0.25 * c * c);
  const double zero_rounding = 1e-12;  // zeros near 25 s are known to an eps of 25
  const double slope_rounding = 1e-9;  // h^4 of the extrapolation and eps A / h
  const auto zeros = zeros_of(printed).size();
  judge_near(outcome, "zeros of the printed form" + label, static_cast<double>(zeros), "1", 0.0,
             0.0, "theory: a bare exponential has none");
  judge_near(outcome, "frequency as plotted" + label, frequency_of(zeros_of(plotted)), "rad/s", 1.0,
             zero_rounding, "theory: omega0, whatever c is; rounding");
  judge_near(outcome, "initial velocity as plotted" + label, slope_at_zero(plotted), "m/s",
             -0.5 * c * amplitude, slope_rounding, "theory: -gamma A, not rest");
  judge_near(outcome, "initial velocity, exact" + label, slope_at_zero(exact), "m/s", 0.0,
             slope_rounding, "the stated start from rest");
  const std::vector<double> crossings = zeros_of(exact);
  if (crossings.size() >= 2) {
    judge_near(outcome, "frequency, exact" + label, frequency_of(crossings), "rad/s", omega1,
               zero_rounding * 1e2, "theory: omega0 sqrt(1 - S^2); rounding of a faint crossing");
  }
  table.rows.push_back({c, static_cast<double>(zeros), frequency_of(zeros_of(plotted)), omega1,
                        slope_at_zero(plotted), slope_at_zero(exact)});
}

Figure draw_forms(double c) {
  Oscillator o = paper_oscillator(c);
  o.displacement = amplitude;
  Figure figure{.id = "c-" + id_of(text(c)),
                .title = "Eq. 6 in three readings, c = " + text(c) + " N s/m",
                .caption =
                    "The printed form only decays; as plotted it swings at omega0 and does "
                    "not start from rest; the exact motion, which the model follows, swings at "
                    "omega1 and does.",
                .x = {.label = "time (s)"},
                .y = {.label = "position (m)"}};
  Series printed{.label = "as printed", .style = Series::Style::dashed};
  Series plotted{.label = "as plotted", .style = Series::Style::line_and_points};
  Series exact{.label = "exact"};
  for (const double t : instants(0.25, 100)) {
    for (Series* series : {&printed, &plotted, &exact}) { series->x.push_back(t); }
    printed.y.push_back(equation_6_printed(o, amplitude, t));
    plotted.y.push_back(equation_6_plotted(o, amplitude, 0.0, t));
    exact.y.push_back(exact_motion(o, t).position);
  }
  figure.series = {std::move(printed), std::move(plotted), std::move(exact)};
  return figure;
}

/// Which of the three the equation of motion itself follows, by the model's Runge-Kutta.
void judge_model(const CaseContext& context, Outcome& outcome, double c, Figure& figure) {
  Oscillator o = paper_oscillator(c);
  o.displacement = amplitude;
  const double h = 0.05;
  const long steps = 500;
  const Samples found = samples_of(run(context, o, "rk4", h, steps));
  const Samples exact = exact_samples(o, instants(h, steps));
  // The energy norm never grows: Taylor remainders of (h |G|)^5 / 120 only add up, |G|^2 = 2 + c^2.
  const double bound =
      static_cast<double>(steps) * std::pow(h * std::sqrt(2.0 + c * c), 5.0) / 120.0;
  outcome.judge({.name = "model from the exact form over its peak, c = " + text(c),
                 .value = peak_distance(found.position, exact.position),
                 .upper = bound,
                 .bound_from = "Taylor remainder of 500 steps"});
  Series points{.label = "model, Runge-Kutta", .style = Series::Style::points};
  for (std::size_t n = 0; n < found.time.size(); n += 20) {
    points.x.push_back(found.time[n]);
    points.y.push_back(found.position[n]);
  }
  figure.series.push_back(std::move(points));
}

void measure_figure_6(const CaseContext& context, Outcome& outcome) {
  Table table{.id = "forms",
              .title = "What the three readings of Eq. 6 do",
              .caption = "Zeros, frequencies and initial velocities of the three forms.",
              .columns = {"c (N s/m)", "zeros as printed (1)", "frequency as plotted (rad/s)",
                          "omega1 (rad/s)", "initial velocity as plotted (m/s)",
                          "initial velocity, exact (m/s)"}};
  for (const double c : paper_viscosities) {
    judge_forms(outcome, c, table);
    Figure figure = draw_forms(c);
    judge_model(context, outcome, c, figure);
    outcome.figures.push_back(std::move(figure));
  }
  outcome.tables.push_back(std::move(table));
  outcome.notes.emplace_back(
      "Eq. 6 as printed multiplies omega0 t by a phase of zero and cannot oscillate; the curves "
      "that "
      "the paper plots have the frequency of an undamped spring and are thrown inwards at gamma "
      "A.");
}

/// Figs. 7-9: one scheme each, with the trace and determinant of its step (m = k = 1).
struct SchemeFigure {
  std::string name;
  std::string scheme;
  std::string title;
  double (*trace)(double c, double h);
  double (*determinant)(double c, double h);
};

double semi_implicit_trace(double c, double h) { return 2.0 - c * h - h * h; }
double semi_implicit_determinant(double c, double h) { return 1.0 - c * h; }

const std::array<SchemeFigure, 3>& scheme_figures() {
  static const std::array<SchemeFigure, 3> figures{
      SchemeFigure{"figure-7", "euler", "Euler", [](double c, double h) { return 2.0 - c * h; },
                   [](double c, double h) { return 1.0 - c * h + h * h; }},
      SchemeFigure{"figure-8", "euler-cromer", "Euler-Cromer", semi_implicit_trace,
                   semi_implicit_determinant},
      SchemeFigure{"figure-9", "feynman-newton-printed", "Feynman-Newton as printed",
                   semi_implicit_trace, semi_implicit_determinant}};
  return figures;
}

void add_targets(Figure& figure, const Oscillator& oscillator) {
  const std::vector<double> fine = instants(0.1, 250);
  figure.series.push_back({.label = "Eq. 6 as plotted",
                           .style = Series::Style::dashed,
                           .x = fine,
                           .y = equation_6_samples(oscillator, fine)});
  figure.series.push_back(
      {.label = "exact", .x = fine, .y = exact_samples(oscillator, fine).position});
}

/// The recurrence that a curve obeys says which scheme drew it, and at which damping and step.
struct Misses {
  double trace = 0.0;        ///< largest |found - theory| over the rounding of the fit
  double determinant = 0.0;  ///< likewise
  double position = 0.0;     ///< largest distance from the closed form over its peak
};

Recurrence compare(Misses& misses, const SchemeFigure& one, double c, double h,
                   const Samples& curve) {
  const Recurrence found = identify_recurrence(curve.position);
  const long steps = std::lround(paper_duration / h);
  misses.position = worse(
      misses.position,
      peak_distance(curve.position, closed_positions(one.scheme, paper_oscillator(c), h, steps)));
  const double rounding = 10.0 * epsilon * found.condition;
  misses.trace = worse(misses.trace, std::abs(found.trace - one.trace(c, h)) / rounding);
  misses.determinant =
      worse(misses.determinant, std::abs(found.determinant - one.determinant(c, h)) / rounding);
  return found;
}

void judge_misses(Outcome& outcome, const Misses& misses) {
  for (const auto& [name, value] :
       {std::pair{"trace", misses.trace}, std::pair{"determinant", misses.determinant}}) {
    outcome.judge({.name = std::string("largest miss of the step's ") + name + " over its rounding",
                   .value = value,
                   .upper = 1.0,
                   .bound_from = "theory of the step; 10 operations a step at one eps each, times "
                                 "the condition of the fit"});
  }
  outcome.judge({.name = "largest distance from the closed form over its peak",
                 .value = misses.position,
                 .upper = 10.0 * 250.0 * epsilon,
                 .bound_from = "10 operations in each of 250 steps at one eps each"});
}

void measure_scheme_figure(const CaseContext& context, Outcome& outcome, const SchemeFigure& one) {
  Table table{
      .id = "distances",
      .title = one.title + " against Eq. 6",
      .caption =
          "Root mean square distances over 25 s, and the trace and determinant of "
          "the step read off the curve and from theory.",
      .columns = {"c (N s/m)", "h (s)", "from Eq. 6 as plotted (m)", "from the exact motion (m)",
                  "trace (1)", "its theory (1)", "determinant (1)", "its theory (1)"}};
  Misses misses;
  for (const double c : paper_viscosities) {
    const Oscillator oscillator = paper_oscillator(c);
    Figure figure{.id = "c-" + id_of(text(c)),
                  .title = one.title + ", c = " + text(c) + " N s/m",
                  .caption = one.title +
                             " at both steps of the paper beside Eq. 6 as plotted and "
                             "the exact motion.",
                  .x = {.label = "time (s)"},
                  .y = {.label = "position (m)"}};
    for (const double h : paper_steps) {
      const long steps = std::lround(paper_duration / h);
      const Samples found = samples_of(run(context, oscillator, one.scheme, h, steps));
      const Samples exact = exact_samples(oscillator, instants(h, steps));
      const Recurrence recurrence = compare(misses, one, c, h, found);
      table.rows.push_back(
          {c, h, rms_distance(found.position, equation_6_samples(oscillator, exact.time)),
           rms_distance(found.position, exact.position), recurrence.trace, one.trace(c, h),
           recurrence.determinant, one.determinant(c, h)});
      figure.series.push_back({.label = one.title + ", h = " + text(h) + " s",
                               .style = Series::Style::line_and_points,
                               .x = found.time,
                               .y = found.position});
    }
    add_targets(figure, oscillator);
    outcome.figures.push_back(std::move(figure));
  }
  judge_misses(outcome, misses);
  outcome.tables.push_back(std::move(table));
}

}  // namespace

std::vector<Case> figure_cases() {
  std::vector<Case> cases{
      {.name = "oscillator/figure-6",
       .suite = "accuracy",
       .claim = "Eq. 6 as printed, as plotted and exact are three different motions.",
       .measure = measure_figure_6,
       .weight = 0.1}};
  for (const SchemeFigure& one : scheme_figures()) {
    cases.push_back(
        {.name = "oscillator/" + one.name,
         .suite = "accuracy",
         .claim = one.title + " moves by the recurrence that its definition gives at "
                              "every damping and step of the paper.",
         .measure = [&one](const CaseContext& context,
                           Outcome& outcome) { measure_scheme_figure(context, outcome, one); },
         .weight = 0.3});
  }
  return cases;
}

}  // namespace palpate::oscillator
