// SPDX-License-Identifier: MIT
/// All schemes over all dampings.

#include <cmath>
#include <limits>

#include "model/stepping/integrator.hpp"
#include "validation/cases/oscillator_parts.hpp"
#include "validation/cases/oscillator_setting.hpp"

namespace palpate::oscillator {

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

/// Errors of one scheme at one damping for h = 0.1 and 0.01 s against the exact motion, and the
/// same from the closed form.
void sweep_scheme(const CaseContext& context, Outcome& outcome, const IntegratorInfo& info,
                  Table& table) {
  const std::string scheme(info.name);
  double surprise = 0.0;
  for (const double h : {0.1, 0.01}) {
    const long steps = std::lround((context.quick ? 5.0 : paper_duration) / h);
    std::vector<Cell> row{scheme, h};
    for (const double c : swept_viscosities) {
      const Oscillator oscillator = paper_oscillator(c);
      const std::vector<double> exact = exact_samples(oscillator, instants(h, steps)).position;
      const std::vector<double> closed = closed_positions(scheme, oscillator, h, steps);
      const std::vector<double> found =
          samples_of(run(context, oscillator, scheme, h, steps)).position;
      const double error = peak_distance(found, exact);
      surprise = worse(surprise, std::abs(error - peak_distance(closed, exact)));
      row.emplace_back(error);
    }
    const Samples driven = exact_samples(driven_oscillator(), instants(h, steps));
    row.emplace_back(peak_distance(
        samples_of(run(context, driven_oscillator(), scheme, h, steps)).position, driven.position));
    table.rows.push_back(std::move(row));
  }
  const double steps = paper_duration / 0.01;
  outcome.judge({.name = "error less the closed form's error, " + scheme,
                 .value = surprise,
                 .upper = 100.0 * steps * epsilon,
                 .bound_from = "closed form; at most 100 operations a step at one eps each"});
  const std::size_t last = table.rows.size() - 1;
  const double coarse = std::get<double>(table.rows[last - 1].back());
  const double fine = std::get<double>(table.rows[last].back());
  outcome.judge({.name = "decades of error per decade of step, driven, " + scheme,
                 .value = std::log10(coarse / fine),
                 .lower = info.order_damped - 0.15,
                 .upper = info.order_damped + 0.15,
                 .bound_from = "order of the scheme with damping"});
}

void measure_sweep(const CaseContext& context, Outcome& outcome) {
  Table table{.id = "errors",
              .title = "Errors of every scheme over the sweep of damping",
              .caption =
                  "Largest position error against the exact motion relative to its peak, "
                  "for free motions by c and for the driven one.",
              .columns = {"scheme", "h (s)"}};
  for (const double c : swept_viscosities) { table.columns.push_back("c = " + text(c) + " (1)"); }
  table.columns.emplace_back("driven (1)");
  for (const IntegratorInfo* info : integrators()) { sweep_scheme(context, outcome, *info, table); }
  Figure figure{.id = "errors",
                .title = "Error over damping, h = 0.01 s",
                .caption =
                    "The order of a scheme sets its error at every damping; of the half-step "
                    "methods only the centred damping keeps it.",
                .x = {.label = "c (N s/m)"},
                .y = {.label = "largest error over peak (1)", .logarithmic = true}};
  for (std::size_t n = 1; n < table.rows.size(); n += 2) {
    Series series{.label = std::get<std::string>(table.rows[n][0]),
                  .style = Series::Style::line_and_points};
    for (std::size_t i = 0; i < swept_viscosities.size(); ++i) {
      series.x.push_back(swept_viscosities[i]);
      series.y.push_back(std::get<double>(table.rows[n][i + 2]));
    }
    figure.series.push_back(std::move(series));
  }
  outcome.tables.push_back(std::move(table));
  outcome.figures.push_back(std::move(figure));
}

}  // namespace

std::vector<Case> sweep_cases() {
  return {{.name = "oscillator/sweep",
           .suite = "accuracy",
           .claim = "Every scheme errs by what its closed form predicts, from no damping to "
                    "overdamped.",
           .measure = measure_sweep,
           .weight = 3.0}};
}

}  // namespace palpate::oscillator
