// SPDX-License-Identifier: MIT
/// The step at which a small lattice blows up, found by running it, against the limit that follows
/// from the exact eigenvalues of its assembled matrices.
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "model/dynamics/problem.hpp"
#include "model/stepping/spectral_bounds.hpp"
#include "model/stepping/stability.hpp"
#include "validation/cases/stability.hpp"
#include "validation/cases/stability_networks.hpp"

namespace palpate::stability {

namespace {

constexpr double amplitude = 5e-12;       // [m] of 5 mm: strains of 1e-9, so linear theory holds
constexpr double blown_up = 1e3;          // times the initial displacement
constexpr double resolution = 1e-3;       // runs are long enough to show growth this far beyond
constexpr double infinite = std::numeric_limits<double>::infinity();

/// Largest displacement in a run over the largest at its start.
double growth_of_run(const CaseContext& context, const IntegratorInfo& scheme,
                     const SpringNetwork& network, double h, long steps) {
  const Scene scene = scene_of(std::string(scheme.name), h, h * static_cast<double>(steps));
  const Motion motion = simulate(context, scene, &network, {.every = std::max(1L, steps / 40)});
  if (motion.diverged || !motion.position.allFinite()) { return infinite; }
  const NetworkProblem problem(network);
  SpringNetwork resting = network;
  resting.initial_displacement = {};
  const Eigen::VectorXd rest = NetworkProblem(resting).initial_position();
  const Eigen::VectorXd largest =
      (motion.position.colwise() - rest).cwiseAbs().colwise().maxCoeff().transpose();
  return largest.maxCoeff() / largest(0);
}

/// Steps after which `blown_up` is passed a hundredfold at `resolution` beyond the limit.
long steps_needed(const IntegratorInfo& scheme, const NetworkLimit& limit) {
  const double growth = growth_per_step(scheme, limit.omega, limit.damping_ratio,
                                        limit.h * (1.0 + resolution));
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
  double relaxation = 0.0;
  NetworkLimit limit{};
  double measured = 0.0;
  double guaranteed = 0.0;
  double automatic = 0.0;  ///< the step that substeps = "auto" takes
};

std::string label_of(double damping_ratio) {
  char text[32];
  std::snprintf(text, sizeof text, "S = %.3g", damping_ratio);
  return text;
}

void judge_row(const Row& row, Outcome& outcome) {
  const std::string at = " at relaxation " + std::to_string(row.relaxation * 1e3).substr(0, 4) + " ms";
  outcome.judge({.name = "blow-up step over theory" + at,
                 .value = row.measured / row.limit.h,
                 .lower = 0.998,
                 .upper = 1.002,
                 .bound_from = "exact eigenvalues; runs resolve 0.1 %, bisection 0.05 %"});
  outcome.judge({.name = "guaranteed step over true limit" + at,
                 .value = row.guaranteed / row.limit.h,
                 .lower = 0.5,
                 .upper = 1.0 + 1e-9,
                 .bound_from = "theory: a bound lies on the safe side, and within 6 dB to be of use"});
  outcome.judge({.name = "margin of automatic substeps" + at,
                 .value = margin_db(row.limit.h, row.automatic),
                 .unit = "dB",
                 .lower = 20.0 * std::log10(2.0),
                 .bound_from = "design: at most half of the guaranteed step"});
}

void draw(const std::vector<Series>& growth, Outcome& outcome) {
  Figure figure{.id = "growth", .title = "Growth around the stability limit",
                .caption = "Largest displacement of a run over its initial one, for every step "
                           "that the bisection tried; runs above the line count as blown up.",
                .x = {.label = "step / theoretical limit (1)", .minimum = 0.94, .maximum = 1.06},
                .y = {.label = "largest displacement / initial (1)", .logarithmic = true}};
  figure.series = growth;
  figure.series.push_back({.label = "counts as blown up", .style = Series::Style::dashed,
                           .x = {0.94, 1.06}, .y = {blown_up, blown_up}});
  outcome.figures.push_back(std::move(figure));
}

void tabulate(const std::vector<Row>& rows, Outcome& outcome) {
  Table table{.id = "limits", .title = "Steps at which the lattice blows up",
              .caption = "3 x 3 x 3 nodes; S is the damping ratio of the mode that fails first.",
              .columns = {"relaxation c/k (ms)", "omega (rad/s)", "S (1)", "theory (ms)",
                          "measured (ms)", "guaranteed (ms)", "automatic (ms)", "margin (dB)"}};
  for (const Row& row : rows) {
    table.rows.push_back({1e3 * row.relaxation, row.limit.omega, row.limit.damping_ratio,
                          1e3 * row.limit.h, 1e3 * row.measured, 1e3 * row.guaranteed,
                          1e3 * row.automatic, margin_db(row.limit.h, row.automatic)});
  }
  outcome.tables.push_back(std::move(table));
}

/// The step that the plan takes by itself for a tick of ten times the limit.
double automatic_step(const CaseContext& context, const IntegratorInfo& scheme,
                      const SpringNetwork& network, double limit) {
  Scene scene = scene_of(std::string(scheme.name), 10.0 * limit, 10.0 * limit);
  scene.simulation.substeps.reset();
  return simulate(context, scene, &network).h;
}

void measure_explicit(const IntegratorInfo& scheme, const CaseContext& context, Outcome& outcome) {
  std::vector<double> relaxations{2e-5, 4e-4};  // [s]
  if (!context.quick) { relaxations.insert(relaxations.begin() + 1, 1.5e-4); }
  if (scheme.name != "euler") { relaxations.insert(relaxations.begin(), 0.0); }
  std::vector<Row> rows;
  std::vector<Series> growth;
  for (const double relaxation : relaxations) {
    SpringNetwork network = cube(3, relaxation);
    Row row{.relaxation = relaxation,
            .limit = network_limit(scheme, spectrum_of(network), relaxation)};
    const SpectralBounds bounds = spectral_bounds(NetworkProblem(network));
    row.guaranteed = stable_step(scheme, bounds);
    row.automatic = automatic_step(context, scheme, network, row.limit.h);
    displace(network, amplitude);
    const long steps = steps_needed(scheme, row.limit);
    std::vector<Run> runs;
    row.measured = blow_up_step(
        row.limit.h, [&](double h) { return growth_of_run(context, scheme, network, h, steps); }, runs);
    Series points{.label = label_of(row.limit.damping_ratio), .style = Series::Style::points};
    for (const Run& run : runs) {
      if (!std::isfinite(run.growth)) { continue; }
      points.x.push_back(run.h / row.limit.h);
      points.y.push_back(run.growth);
    }
    growth.push_back(std::move(points));
    judge_row(row, outcome);
    rows.push_back(row);
  }
  tabulate(rows, outcome);
  draw(growth, outcome);
}

}  // namespace

}  // namespace palpate::stability
