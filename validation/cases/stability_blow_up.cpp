// SPDX-License-Identifier: MIT
/// The step at which a small lattice blows up, found by running it, against the limit that follows
/// from the exact eigenvalues of its assembled matrices. Schemes without a limit are run at a huge
/// step, schemes without a stable step at small ones.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <string>

#include "model/dynamics/problem.hpp"
#include "model/stepping/spectral_bounds.hpp"
#include "model/stepping/stability.hpp"
#include "validation/cases/stability.hpp"
#include "validation/cases/stability_networks.hpp"

namespace palpate::stability {

namespace {

constexpr double tiny = 5e-12;       // [m] of 5 mm: strains of 1e-9, so linear theory holds
constexpr double moderate = 1e-6;    // [m]
constexpr double blown_up = 1e3;     // times the initial displacement
constexpr double resolution = 1e-3;  // runs are long enough to show growth this far beyond
constexpr double most_drawn = 1e3 * blown_up;  // beyond, rounding decides where a run overflows
constexpr double infinite = std::numeric_limits<double>::infinity();

/// Largest displacement in a run over the largest at its start.
double growth_of_run(const CaseContext& context, const IntegratorInfo& scheme,
                     const SpringNetwork& network, double h, long steps) {
  const Scene scene = scene_of(std::string(scheme.name), h, h * static_cast<double>(steps));
  const Motion motion =
      simulate(context, scene, &network, Wanted{.every = std::max(1L, steps / 40)});
  if (motion.diverged || !motion.position.allFinite()) { return infinite; }
  const Eigen::VectorXd rest = rest_position(network);
  const Eigen::VectorXd largest =
      (motion.position.colwise() - rest).cwiseAbs().colwise().maxCoeff().transpose();
  return largest.maxCoeff() / largest(0);
}

/// Steps after which `blown_up` is passed a hundredfold at `resolution` beyond the limit.
long steps_needed(const IntegratorInfo& scheme, const NetworkLimit& limit) {
  const double growth =
      growth_per_step(scheme, limit.omega, limit.damping_ratio, limit.h * (1.0 + resolution));
  return std::lround(std::clamp(std::log(100.0 * blown_up) / std::log(growth), 2e3, 3e5));
}

struct Run {
  double h;
  double growth;
};

/// Bisection between a run that stays and one that blows up, from 5 % around the expected limit;
/// further out where that is not enough, and 0 or infinite where nothing is.
double blow_up_step(double expected, const std::function<double(double)>& growth,
                    std::vector<Run>& runs) {
  const auto blows_up = [&](double h) {
    runs.push_back({h, growth(h)});
    return !(runs.back().growth < blown_up);
  };
  double low = 0.95 * expected;
  double high = 1.05 * expected;
  while (blows_up(low)) {
    high = low;
    low *= 0.5;
    if (low < 0.01 * expected) { return 0.0; }
  }
  while (high >= 1.05 * expected && !blows_up(high)) {
    low = high;
    high *= 2.0;
    if (high > 10.0 * expected) { return infinite; }
  }
  while (high - low > 0.5 * resolution * expected) {
    const double middle = 0.5 * (low + high);
    (blows_up(middle) ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

struct Row {
  double relaxation = 0.0;  ///< [s]
  NetworkLimit limit{};
  double measured = 0.0;    ///< [s]
  double guaranteed = 0.0;  ///< [s]
  double automatic = 0.0;   ///< [s] what substeps = "auto" takes
};

std::string text(const char* format, double value) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

void judge_row(const Row& row, Outcome& outcome) {
  const std::string at = text(", c/k = %g ms", 1e3 * row.relaxation);
  outcome.judge({.name = "blow-up step over theory" + at,
                 .value = row.measured / row.limit.h,
                 .lower = 0.998,
                 .upper = 1.002,
                 .bound_from = "exact eigenvalues; runs resolve 0.1 %, bisection 0.05 %"});
  outcome.judge({.name = "guaranteed step over true limit" + at,
                 .value = row.guaranteed / row.limit.h,
                 .lower = 0.5,
                 .upper = 1.0 + 1e-9,
                 .bound_from = "a bound lies on the safe side, and within 6 dB to be of use"});
  outcome.judge({.name = "margin of automatic substeps" + at,
                 .value = margin_db(row.limit.h, row.automatic),
                 .unit = "dB",
                 .lower = 20.0 * std::log10(2.0) - 1e-9,
                 .bound_from = "automatic substeps stay at half of the guaranteed step"});
}

/// The step that the plan takes by itself for a tick of ten times the limit.
double automatic_step(const CaseContext& context, const IntegratorInfo& scheme,
                      const SpringNetwork& network, double limit) {
  Scene scene = scene_of(std::string(scheme.name), 10.0 * limit, 10.0 * limit);
  scene.simulation.substeps.reset();
  return simulate(context, scene, &network).h;
}

Row find_limit(const IntegratorInfo& scheme, const CaseContext& context, SpringNetwork network,
               const Row& expected, std::vector<Series>& growth) {
  Row row = expected;
  row.guaranteed = stable_step(scheme, spectral_bounds(NetworkProblem(network)));
  row.automatic = automatic_step(context, scheme, network, row.limit.h);
  displace(network, tiny);
  const long steps = steps_needed(scheme, row.limit);
  std::vector<Run> runs;
  row.measured = blow_up_step(
      row.limit.h, [&](double h) { return growth_of_run(context, scheme, network, h, steps); },
      runs);
  Series points{.label = text("S = %.3g", row.limit.damping_ratio), .style = Series::Style::points};
  for (const Run& run : runs) {
    points.x.push_back(run.h / row.limit.h);
    points.y.push_back(std::min(run.growth, most_drawn));
  }
  growth.push_back(std::move(points));
  return row;
}

/// A scheme that no step amplifies: no mode may pass its own initial displacement, so all of them
/// together at most the square root of their number times it.
void judge_without_limit(const IntegratorInfo& scheme, const CaseContext& context,
                         SpringNetwork network, const Row& row, double omega, Outcome& outcome) {
  displace(network, moderate);
  outcome.judge({.name = "growth over 200 steps of 1000 / omega_max" +
                         text(", c/k = %g ms", 1e3 * row.relaxation),
                 .value = growth_of_run(context, scheme, network, 1e3 / omega, 200),
                 .upper = std::sqrt(static_cast<double>(NetworkProblem(network).dof())),
                 .bound_from = "A-stability: no mode exceeds its initial amplitude"});
}

/// A scheme that every step amplifies: growth of the fastest mode per step against theory.
void judge_always_unstable(const IntegratorInfo& scheme, const CaseContext& context,
                           SpringNetwork network, double omega, Outcome& outcome) {
  displace(network, tiny);
  for (const double z : {0.02, 0.1, 0.5}) {
    const double growth = growth_per_step(scheme, omega, 0.0, z / omega);
    const long steps = std::lround(std::log(1e8) / std::log(growth));
    const double early = growth_of_run(context, scheme, network, z / omega, steps / 2);
    const double late = growth_of_run(context, scheme, network, z / omega, steps);
    const double measured = std::log(late / early) / static_cast<double>(steps - steps / 2);
    outcome.judge({.name = text("growth rate over theory at h omega_max = %g", z),
                   .value = measured / std::log(growth),
                   .lower = 0.75,
                   .upper = 1.25,
                   .bound_from = "ln|1 + i h omega|; slower modes and phase blur a finite run"});
  }
  outcome.judge({.name = "guaranteed step where none is stable",
                 .value = stable_step(scheme, spectral_bounds(NetworkProblem(network))),
                 .unit = "s",
                 .upper = 0.0,
                 .bound_from = "theory: every step amplifies an undamped oscillator"});
}

void tabulate(const std::vector<Row>& rows, Outcome& outcome) {
  Table table{.id = "limits",
              .title = "Steps at which the lattice blows up",
              .caption = "3 x 3 x 3 nodes; S is the damping ratio of the mode that fails first.",
              .columns = {"c/k (ms)", "omega (rad/s)", "S (1)", "theory (ms)", "measured (ms)",
                          "guaranteed (ms)", "automatic (ms)", "margin (dB)"}};
  for (const Row& row : rows) {
    table.rows.push_back({1e3 * row.relaxation, row.limit.omega, row.limit.damping_ratio,
                          1e3 * row.limit.h, 1e3 * row.measured, 1e3 * row.guaranteed,
                          1e3 * row.automatic, margin_db(row.limit.h, row.automatic)});
  }
  outcome.tables.push_back(std::move(table));
}

void draw(std::vector<Series> growth, Outcome& outcome) {
  Figure figure{.id = "growth",
                .title = "Growth around the stability limit",
                .caption =
                    "Largest displacement of a run over its initial one, for every step "
                    "that the bisection tried; runs above the line count as blown up; all that grew a millionfold stand "
                    "at a million.",
                .x = {.label = "step / theoretical limit (1)", .minimum = 0.94, .maximum = 1.06},
                .y = {.label = "largest displacement / initial (1)", .logarithmic = true}};
  figure.series = std::move(growth);
  figure.series.push_back({.label = "counts as blown up",
                           .style = Series::Style::dashed,
                           .x = {0.94, 1.06},
                           .y = {blown_up, blown_up}});
  outcome.figures.push_back(std::move(figure));
}

void measure(const IntegratorInfo& scheme, const CaseContext& context, Outcome& outcome) {
  std::vector<double> relaxations{0.0, 1.5e-3};  // [s]
  if (!context.quick) { relaxations = {0.0, 4e-4, 1.5e-3, 4e-3}; }
  std::vector<Row> rows;
  std::vector<Series> growth;
  for (const double relaxation : relaxations) {
    const SpringNetwork network = cube(3, relaxation);
    const Spectrum spectrum = spectrum_of(network);
    const Row row{.relaxation = relaxation, .limit = network_limit(scheme, spectrum, relaxation)};
    const double fastest = spectrum.omega.maxCoeff();
    if (row.limit.h == 0.0) {
      judge_always_unstable(scheme, context, network, fastest, outcome);
    } else if (std::isinf(row.limit.h)) {
      judge_without_limit(scheme, context, network, row, fastest, outcome);
    } else {
      rows.push_back(find_limit(scheme, context, network, row, growth));
      judge_row(rows.back(), outcome);
    }
  }
  if (rows.empty()) { return; }
  tabulate(rows, outcome);
  draw(std::move(growth), outcome);
}

}  // namespace

void add_blow_up_cases(std::vector<Case>& cases) {
  for (const IntegratorInfo* scheme : integrators()) {
    cases.push_back({.name = "stability/blow-up/" + std::string(scheme->name),
                     .suite = "stability",
                     .claim = scheme->implicit
                                  ? "no step makes a lattice blow up"
                                  : "a lattice blows up at the step that its exact spectrum "
                                    "predicts, and the guaranteed step lies below it",
                     .measure = [scheme](const CaseContext& context, Outcome& outcome) {
                       measure(*scheme, context, outcome);
                     }});
  }
}

}  // namespace palpate::stability
