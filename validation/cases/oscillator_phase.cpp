// SPDX-License-Identifier: MIT
/// The paper's Fig. 10: orbits in the phase plane, and the area that each scheme gains or loses.

#include <cmath>
#include <limits>

#include "validation/cases/oscillator_parts.hpp"
#include "validation/cases/oscillator_setting.hpp"

namespace palpate::oscillator {

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

struct Drawn {
  std::string scheme;
  std::string title;
  double (*area_factor)(double c, double h);  ///< determinant of a step, m = k = 1
};

constexpr auto semi_implicit = [](double c, double h) { return 1.0 - c * h; };
const std::array<Drawn, 3>& drawn_schemes() {
  static const std::array<Drawn, 3> drawn{
      Drawn{"euler", "Euler", [](double c, double h) { return 1.0 - c * h + h * h; }},
      Drawn{"euler-cromer", "Euler-Cromer", semi_implicit},
      Drawn{"feynman-newton-printed", "Feynman-Newton as printed", semi_implicit}};
  return drawn;
}

/// Two successive states span a parallelogram; each step multiplies its area by the determinant.
double area_factor(const Samples& orbit, long steps) {
  const std::size_t count = static_cast<std::size_t>(steps) + 1;
  if (orbit.position.size() != count || orbit.velocity.size() != count) { return nan; }
  const auto area = [&](std::size_t n) {
    return orbit.position[n] * orbit.velocity[n + 1] - orbit.position[n + 1] * orbit.velocity[n];
  };
  double factor = std::pow(area(count - 2) / area(0), 1.0 / static_cast<double>(count - 2));
  for (const double x : orbit.position) { factor += 0.0 * x; }  // a NaN on the way is one here
  return factor;
}

Figure draw(const CaseContext& context, const Drawn& one, double c) {
  const Oscillator oscillator = paper_oscillator(c);
  Figure figure{.id = one.scheme + "-c-" + id_of(text(c)),
                .title = "Phase portrait of " + one.title + ", c = " + text(c) + " N s/m",
                .caption = "The orbit of " + one.title +
                           " at both steps of the paper beside that "
                           "of the exact motion.",
                .x = {.label = "position (m)"},
                .y = {.label = "velocity (m/s)"},
                .square = true};
  for (const double h : paper_steps) {
    const long steps = std::lround(paper_duration / h);
    const Samples orbit = samples_of(run(context, oscillator, one.scheme, h, steps));
    figure.series.push_back({.label = "h = " + text(h) + " s",
                             .style = Series::Style::line_and_points,
                             .x = orbit.position,
                             .y = orbit.velocity});
  }
  const Samples exact = exact_samples(oscillator, instants(0.05, 500));
  figure.series.push_back({.label = "exact", .x = exact.position, .y = exact.velocity});
  return figure;
}

/// |measured - theory| over its rounding.
double miss_of_area(const CaseContext& context, const Drawn& one, double c, double h,
                    Table& table) {
  // Long enough to see, short enough for the orbit not to vanish in rounding.
  const long steps = 60;
  const Samples orbit = samples_of(run(context, paper_oscillator(c), one.scheme, h, steps));
  const double found = area_factor(orbit, steps);
  const double theory = one.area_factor(c, h);
  table.rows.push_back({one.title, c, h, found, theory, std::exp(-c * h)});
  // The area, h, is a difference of products of order one; what 60 steps add the root divides.
  return std::abs(found - theory) / (10.0 * epsilon / h);
}

void measure_figure_10(const CaseContext& context, Outcome& outcome) {
  Table table{
      .id = "areas",
      .title = "What a step does to an area of the phase plane",
      .caption = "Measured factor, determinant of the step, and the exact exp(-c h / m).",
      .columns = {"scheme", "c (N s/m)", "h (s)", "measured (1)", "theory (1)", "exact (1)"}};
  for (const Drawn& one : drawn_schemes()) {
    double miss = 0.0;
    for (const double h : paper_steps) {
      for (const double c : {0.0, 0.1, 0.7, 1.4}) {
        miss = worse(miss, miss_of_area(context, one, c, h, table));
      }
    }
    outcome.judge({.name = "largest miss of the area factor of " + one.title + " over its rounding",
                   .value = miss,
                   .upper = 1.0,
                   .bound_from = "theory: determinant of the step; 10 operations a step at one eps "
                                 "each, in an area of h"});
    outcome.figures.push_back(draw(context, one, 0.0));
    outcome.figures.push_back(draw(context, one, 0.1));
    if (!context.quick) { outcome.figures.push_back(draw(context, one, 0.7)); }
  }
  outcome.tables.push_back(std::move(table));
  outcome.notes.emplace_back(
      "Without damping Euler-Cromer and Feynman-Newton keep areas exactly and their orbits close; "
      "Euler gains 1 + h^2 per step, and with c = 0.1 N s/m at h = 0.1 s its spiral stands still.");
}

}  // namespace

std::vector<Case> phase_cases() {
  return {{.name = "oscillator/figure-10",
           .suite = "accuracy",
           .claim = "Each scheme gains or loses area of the phase plane as its step's determinant "
                    "says.",
           .measure = measure_figure_10,
           .weight = 0.5}};
}

}  // namespace palpate::oscillator
