// SPDX-License-Identifier: MIT
/// Bounds that determine automatic substeps, compared with exact spectra of random networks.

#include "model/tissue/network_builder.hpp"
#include "reference/exact_problems.hpp"
#include "validation/claims/groups.hpp"
#include "validation/claims/stability_fixture.hpp"
#include "validation/number_text.hpp"
#include "validation/signal.hpp"

namespace palpate::stability {

namespace {

/// Masses, stiffness and viscosity over `decades`; some nodes fixed; rest lengths off by 60 %.
SpringNetwork random_network(std::uint64_t seed, double decades) {
  Random random(seed);
  constexpr int nodes = 16;
  constexpr int springs = 60;
  const auto spread = [&](double largest) {
    return largest * std::pow(10.0, -random(0.0, decades));
  };
  SpringNetwork network;
  network.rest_position = NodeVectors::NullaryExpr(3, nodes, [&] { return random(-0.01, 0.01); });
  network.mass = Eigen::VectorXd::NullaryExpr(nodes, [&] { return spread(1e-2); });
  network.fixed.assign(nodes, 0);
  for (std::size_t n = 0; n < seed % 4; ++n) { network.fixed[5 * n] = 1; }
  for (int n = 0; n < springs; ++n) {
    const int b = n + 1 < nodes ? n + 1 : static_cast<int>(random(1.0, nodes));
    const int a = static_cast<int>(random(0.0, b));
    const double length = (network.rest_position.col(b) - network.rest_position.col(a)).norm();
    network.springs.push_back({a, b, spread(1e4), spread(1.0), length * (1.0 + random(-0.6, 0.6))});
  }
  return network;
}

struct Ratios {
  Series estimate{.label = "power iteration", .style = Series::Style::points};
  Series upper{.label = "guaranteed bound, frequency", .style = Series::Style::points};
  Series damping{.label = "guaranteed bound, damping", .style = Series::Style::points};
};

Ratios ratios_of(const CaseContext& context, int networks) {
  Ratios ratios;
  for (int n = 0; n < networks; ++n) {
    const double decades = 6.0 * n / (networks - 1);
    const SpringNetwork network = random_network(static_cast<std::uint64_t>(n) + 1, decades);
    const Spectrum truth = spectrum_of(network);
    const SpectralBounds bounds =
        spectral_bounds(NetworkProblem(networks::candidate(context, network)));
    const double omega = truth.omega.maxCoeff();
    ratios.estimate.add(decades, bounds.omega_estimate / omega);
    ratios.upper.add(decades, bounds.omega_upper / omega);
    ratios.damping.add(decades, bounds.damping_upper / truth.damping_maximum);
  }
  return ratios;
}

void measure_bounds(const CaseContext& context, Outcome& outcome) {
  Ratios ratios = ratios_of(context, context.quick ? 60 : 400);
  const auto [low_estimate, high_estimate] = std::ranges::minmax(ratios.estimate.y);
  const auto [low_upper, high_upper] = std::ranges::minmax(ratios.upper.y);
  const auto [low_damping, high_damping] = std::ranges::minmax(ratios.damping.y);
  const char* exact = "exact eigenvalues of the assembled matrices";
  outcome.judge_at_most("largest estimate over true frequency", high_estimate, 1.0 + 1e-9, exact);
  outcome.judge_at_least("smallest estimate over true frequency", low_estimate, 0.95,
                         "500 iterations from a start with every wave length");
  outcome.judge_at_least("smallest frequency bound over true", low_upper, 1.0 - 1e-11, exact);
  outcome.judge_at_most("largest frequency bound over true", high_upper, 1.5,
                        "looser, and automatic substeps would waste a third of the work");
  outcome.judge_at_least("smallest damping bound over true", low_damping, 1.0 - 1e-11, exact);
  outcome.judge_at_most("largest damping bound over true", high_damping, 2.25,
                        "as the bound of the frequency, which is its square root");
  outcome.figures.push_back(
      plot("ratios", "Bounds over exact values",
           "Random networks of 16 nodes and 60 springs: the estimate must stay below 1 and the "
           "guaranteed bounds above it.",
           {"spread of mass, stiffness and viscosity (decades)"}, {"bound / exact value (1)"},
           {std::move(ratios.estimate), std::move(ratios.upper), std::move(ratios.damping),
            curve("exact", {0.0, 6.0}, {1.0, 1.0}, Series::Style::dashed)}));
}

// Measured stability limit of a small lattice against its exact eigenvalues. Schemes without a
// limit run at a very large step, schemes without a stable step at small ones.

constexpr double tiny = 5e-12;       // [m] of 5 mm: strains of 1e-9, so linear theory holds
constexpr double moderate = 1e-6;    // [m]
constexpr double blown_up = 1e3;     // times the initial displacement
constexpr double resolution = 1e-3;  // runs are long enough to show growth this far beyond
constexpr double most_drawn = 1e3 * blown_up;  // beyond, rounding decides where a run overflows

/// Largest displacement in a run over the largest at its start.
double growth_of_run(const CaseContext& context, const IntegratorInfo& scheme,
                     const SpringNetwork& network, double h, long steps) {
  const Scene scene = scene_of(std::string(scheme.name), h, h * static_cast<double>(steps));
  const Trace motion =
      roll_out(context, scene, &network, {.every = std::max(1L, steps / 40), .position = true});
  if (motion.diverged || !motion.position.allFinite()) { return unbounded; }
  const Eigen::VectorXd rest = reference::rest_coordinates(NetworkProblem(network));
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

/// Finds the limit by bisection between a stable and an unstable run, from 5 % around the expected
/// limit. The bracket is extended if needed; 0 or infinity if there is no limit.
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
    if (high > 10.0 * expected) { return unbounded; }
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

void judge_row(const Row& row, Outcome& outcome) {
  const std::string at = ", c/k = " + plain_number(1e3 * row.relaxation, 6) + " ms";
  outcome.judge_between("blow-up step over theory" + at, row.measured / row.limit.h, 0.998, 1.002,
                        "exact eigenvalues; runs resolve 0.1 %, bisection 0.05 %");
  outcome.judge_between("guaranteed step over true limit" + at, row.guaranteed / row.limit.h, 0.5,
                        1.0 + 1e-9, "a bound lies on the safe side, and within 6 dB to be of use");
  outcome.judge_at_least("margin of automatic substeps" + at, margin_db(row.limit.h, row.automatic),
                         20.0 * std::log10(2.0) - 1e-9,
                         "automatic substeps stay at half of the guaranteed step", "dB");
}

Row find_limit(const IntegratorInfo& scheme, const CaseContext& context, SpringNetwork network,
               const Row& expected, std::deque<Series>& growth) {
  Row row = expected;
  row.guaranteed = stable_step(scheme, spectral_bounds(NetworkProblem(network)));
  // For a tick of ten times the limit.
  const Scene scene =
      automatic_scene(std::string(scheme.name), 10.0 * row.limit.h, 10.0 * row.limit.h);
  row.automatic = roll_out(context, scene, &network, {.position = true}).h;
  displace(network, tiny);
  const long steps = steps_needed(scheme, row.limit);
  std::vector<Run> runs;
  row.measured = blow_up_step(
      row.limit.h, [&](double h) { return growth_of_run(context, scheme, network, h, steps); },
      runs);
  Series points{.label = "S = " + plain_number(row.limit.damping_ratio, 3),
                .style = Series::Style::points};
  for (const Run& run : runs) { points.add(run.h / row.limit.h, std::min(run.growth, most_drawn)); }
  growth.push_back(std::move(points));
  return row;
}

/// Judges an unconditionally stable scheme: no mode may exceed its initial displacement, so all
/// modes together at most the square root of their number times it.
void judge_without_limit(const IntegratorInfo& scheme, const CaseContext& context,
                         SpringNetwork network, const Row& row, double omega, Outcome& outcome) {
  displace(network, moderate);
  outcome.judge_at_most("growth over 200 steps of 1000 / omega_max, c/k = " +
                            plain_number(1e3 * row.relaxation, 6) + " ms",
                        growth_of_run(context, scheme, network, 1e3 / omega, 200),
                        std::sqrt(static_cast<double>(NetworkProblem(network).dof())),
                        "A-stability: no mode exceeds its initial amplitude");
}

/// Judges an unstable scheme: growth of the fastest mode per step compared with theory.
void judge_always_unstable(const IntegratorInfo& scheme, const CaseContext& context,
                           SpringNetwork network, double omega, Outcome& outcome) {
  displace(network, tiny);
  for (const double z : {0.02, 0.1, 0.5}) {
    const double growth = growth_per_step(scheme, omega, 0.0, z / omega);
    const long steps = std::lround(std::log(1e8) / std::log(growth));
    const double early = growth_of_run(context, scheme, network, z / omega, steps / 2);
    const double late = growth_of_run(context, scheme, network, z / omega, steps);
    const double measured = std::log(late / early) / static_cast<double>(steps - steps / 2);
    outcome.judge_between("growth rate over theory at h omega_max = " + plain_number(z, 6),
                          measured / std::log(growth), 0.75, 1.25,
                          "ln|1 + i h omega|; slower modes and phase blur a finite run");
  }
  outcome.judge_at_most("guaranteed step where none is stable",
                        stable_step(scheme, spectral_bounds(NetworkProblem(network))), 0.0,
                        "theory: every step amplifies an undamped oscillator", "s");
}

void measure_blow_up(const IntegratorInfo& scheme, const CaseContext& context, Outcome& outcome) {
  std::vector<double> relaxations{0.0, 1.5e-3};  // [s]
  if (!context.quick) { relaxations = {0.0, 4e-4, 1.5e-3, 4e-3}; }
  std::vector<Row> rows;
  std::deque<Series> growth;
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
  Table& table =
      outcome.table("limits", "Steps at which the lattice blows up",
                    "3 x 3 x 3 nodes; S is the damping ratio of the mode that fails first.",
                    {"c/k (ms)", "omega (rad/s)", "S (1)", "theory (ms)", "measured (ms)",
                     "guaranteed (ms)", "automatic (ms)", "margin (dB)"});
  for (const Row& row : rows) {
    table.rows.push_back({1e3 * row.relaxation, row.limit.omega, row.limit.damping_ratio,
                          1e3 * row.limit.h, 1e3 * row.measured, 1e3 * row.guaranteed,
                          1e3 * row.automatic, margin_db(row.limit.h, row.automatic)});
  }
  Figure& figure =
      outcome.plot("growth", "Growth around the stability limit",
                   "Largest displacement over the initial one, for every step of the bisection; "
                   "runs above the line are unstable; growth is drawn up to a million.",
                   {.label = "step / theoretical limit (1)", .minimum = 0.94, .maximum = 1.06},
                   logarithmic("largest displacement / initial (1)"));
  figure.series = std::move(growth);
  figure.add("counts as blown up", {0.94, 1.06}, {blown_up, blown_up}, Series::Style::dashed);
}

// Growth per step of every scheme over step length and damping, measured by running it, with the
// border of stability from theory and from bisection.

constexpr double highest_step = 3.5;     // h omega0
constexpr double highest_damping = 2.0;  // S

/// x'' + 2 S x' + x = 0 under a scheme.
Trace run(const CaseContext& context, const IntegratorInfo& scheme, double damping_ratio, double h,
          long steps, long every) {
  Scene scene = scene_of(std::string(scheme.name), h, h * static_cast<double>(steps));
  scene.tissue.source = Source::oscillator;
  scene.tissue.oscillator = {.mass = 1.0,
                             .stiffness = 1.0,
                             .viscosity = 2.0 * damping_ratio,
                             .displacement = 1.0,
                             .velocity = 0.3};
  return roll_out(context, scene, {.every = every, .position = true, .velocity = true});
}

double size_at(const Trace& motion, Eigen::Index n) {
  return std::hypot(motion.position(0, n), motion.velocity(0, n));
}

/// log10 of the growth per step over the second half of a short run, within -1 and 1.
double log_growth(const CaseContext& context, const IntegratorInfo& scheme, double s, double h) {
  constexpr long steps = 60;
  const Trace motion = run(context, scheme, s, h, steps, 1);
  const Eigen::Index last = motion.position.cols() - 1;
  const Eigen::Index middle = last / 2;
  if (last < 4) { return 1.0; }  // out of bounds at once
  const double ratio = size_at(motion, last) / size_at(motion, middle);
  const double growth = std::log10(ratio) / static_cast<double>(last - middle);
  return std::isnan(growth) ? growth : std::clamp(growth, -1.0, 1.0);
}

HeatMap heat_map(const CaseContext& context, const IntegratorInfo& scheme) {
  const int columns = context.quick ? 21 : 41;
  const int rows = context.quick ? 18 : 36;
  HeatMap map{.label = "log10 of growth per step (1)"};
  for (int i = 0; i < columns; ++i) { map.x.push_back(highest_damping * i / (columns - 1)); }
  for (int j = 0; j < rows; ++j) { map.y.push_back(highest_step * (j + 1) / rows); }
  for (const double h : map.y) {
    for (const double s : map.x) { map.z.push_back(log_growth(context, scheme, s, h)); }
  }
  return map;
}

bool blows_up(const CaseContext& context, const IntegratorInfo& scheme, double s, double h,
              long steps) {
  const Trace motion = run(context, scheme, s, h, steps, std::max(1L, steps / 20));
  return motion.diverged || !(size_at(motion, motion.position.cols() - 1) < blown_up);
}

/// Border by bisection of long runs; infinite when twice the expected step is still stable.
double measured_border(const CaseContext& context, const IntegratorInfo& scheme, double s,
                       double expected) {
  const double growth = growth_per_step(scheme, 1.0, s, expected * (1.0 + resolution));
  const double wanted = std::log(30.0 * blown_up) / std::log(growth);
  const long steps = std::lround(std::clamp(wanted, 500.0, 2e6));
  double low = 0.0;
  double high = 2.0 * expected;
  if (!blows_up(context, scheme, s, high, steps)) { return unbounded; }
  double middle = expected;  // expected first: both sides of it are near then
  while (high - low > 0.5 * resolution * expected) {
    (blows_up(context, scheme, s, middle, steps) ? high : low) = middle;
    const double gap = resolution * expected;
    middle = low == expected    ? std::min(expected + gap, 0.5 * (low + high))
             : high == expected ? std::max(expected - gap, 0.5 * (low + high))
                                : 0.5 * (low + high);
  }
  return 0.5 * (low + high);
}

struct Borders {
  Series theory{.label = "border, theory", .style = Series::Style::line};
  Series measured{.label = "border, measured", .style = Series::Style::points};
  Largest distance{};
};

Borders borders_of(const CaseContext& context, const IntegratorInfo& scheme) {
  Borders borders;
  for (int n = 0; n <= 200; ++n) {
    const double s = highest_damping * n / 200;
    borders.theory.add(s, scalar_limit(scheme, 1.0, s));
  }
  const int points = context.quick ? 5 : 11;
  for (int n = 0; n < points; ++n) {
    const double s = highest_damping * n / (points - 1);
    const double expected = scalar_limit(scheme, 1.0, s);
    if (expected == 0.0) { continue; }
    const double measured = measured_border(context, scheme, s, expected);
    borders.measured.add(s, measured);
    borders.distance.add(std::abs(measured / expected - 1.0));
  }
  return borders;
}

void measure_map(const IntegratorInfo& scheme, const CaseContext& context, Outcome& outcome) {
  Figure& figure =
      outcome.plot("map", "Growth per step of " + std::string(scheme.name),
                   "Growth of x'' + 2 S x' + x = 0 per step, measured over 60 steps; the points "
                   "are the border found by bisection of long runs.",
                   {.label = "damping ratio S (1)", .minimum = 0.0, .maximum = highest_damping},
                   {.label = "h omega0 (1)", .minimum = 0.0, .maximum = highest_step});
  figure.heat_map = heat_map(context, scheme);
  if (std::isinf(scalar_limit(scheme, 1.0, 0.5))) {
    // The size of a state and its energy are the same here, and A-stable schemes keep that.
    Largest growth(-unbounded);
    for (const double z : figure.heat_map->z) { growth.add(z); }
    outcome.judge_at_most("largest log10 growth per step", growth.value(), 1e-9,
                          "A-stability: no step amplifies, at any damping");
  } else {
    Borders borders = borders_of(context, scheme);
    outcome.judge_at_most("largest relative distance of the borders", borders.distance.value(),
                          2e-3, "closed forms and exact 2 x 2 matrices; runs resolve 0.1 %");
    figure.series = {std::move(borders.theory), std::move(borders.measured)};
    if (scalar_limit(scheme, 1.0, 0.0) == 0.0) {
      outcome.notes.emplace_back(
          "S = 0 has no border: every step amplifies (judged by stability/blow-up)");
    }
  }
}

// Stiffness and mass over six decades within one network, stepped with automatic substeps.

constexpr int side = 4;
constexpr double tick = 1e-3;       // [s]
constexpr double duration = 0.05;   // [s]
constexpr double amplitude = 1e-8;  // [m] of 5 mm: linear theory holds to 1e-5

enum class Varied { stiffness, mass };

/// Nodes of the inner 2 x 2 x 2 block.
bool is_inner(int node) {
  const int i = node % side;
  const int j = node / side % side;
  const int l = node / (side * side);
  return i % 3 != 0 && j % 3 != 0 && l % 3 != 0;
}

/// Undamped block with springs `ratio` times stiffer, or nodes `ratio` times lighter, inside.
SpringNetwork block(Varied varied, double ratio) {
  SpringNetwork network = cube(side, 0.0);
  if (varied == Varied::stiffness) {
    network.springs.change_each([&](Spring& s) {
      if (is_inner(s.a) && is_inner(s.b)) { s.stiffness *= ratio; }
    });
    return network;
  }
  for (int i = 0; i < network.node_count(); ++i) {
    if (is_inner(i)) { network.mass(i) /= ratio; }
  }
  return network;
}

struct Rung {
  double ratio = 0.0;
  double limit = 0.0;  ///< of the scheme that stepped, from the exact spectrum [s]
  Trace motion{};
  double energy_growth = 0.0;  ///< largest over initial
  double energy_bound = 0.0;   ///< the same, from theory
};

Rung climb(const CaseContext& context, const std::string& integrator, Varied varied, double ratio) {
  SpringNetwork network = block(varied, ratio);
  const Spectrum spectrum = spectrum_of(network);
  displace(network, amplitude);
  Rung rung{.ratio = ratio};
  rung.motion = roll_out(context, automatic_scene(integrator, tick, duration), &network,
                         {.position = true, .energy = true});
  // "auto" leaves velocity Verlet for the implicit midpoint rule, which alone passes the limit.
  const IntegratorInfo* scheme =
      find_integrator(integrator == "auto" ? "velocity-verlet" : integrator);
  rung.limit = network_limit(*scheme, spectrum, 0.0).h;
  if (integrator == "auto" && rung.motion.h > rung.limit) {
    scheme = find_integrator("implicit-midpoint");
    rung.limit = unbounded;
  }
  rung.energy_growth = energy_growth(rung.motion);
  rung.energy_bound = energy_ratio_bound(*scheme, spectrum.omega.maxCoeff() * rung.motion.h);
  return rung;
}

void judge_ladder(const std::string& integrator, const std::vector<Rung>& ladder, Table& table,
                  Outcome& outcome) {
  Largest worst_growth;
  Smallest least_margin;
  for (const Rung& rung : ladder) {
    worst_growth.add(rung.energy_growth / rung.energy_bound);
    const double margin = margin_db(rung.limit, rung.motion.h);
    least_margin.add(margin);
    table.rows.push_back({integrator, rung.ratio, rung.motion.substeps, 1e6 * rung.motion.h, margin,
                          rung.energy_growth, rung.energy_bound});
  }
  outcome.judge_at_most(integrator + ": largest energy over initial, over theory",
                        worst_growth.value(), 1.0 + 1e-4,
                        "quadratic form that the scheme keeps exactly; strains of 1e-5");
  outcome.judge_at_least(integrator + ": least margin over the decades", least_margin.value(),
                         20.0 * std::log10(2.0) - 1e-9,
                         "automatic substeps stay at half of the guaranteed step", "dB");
}

/// Error of a slow push at a modest contrast: the second-order phase error of the modes up to
/// 500 rad/s, which carry the response to a 20 ms half sine.
void judge_accuracy(const CaseContext& context, Varied varied, Outcome& outcome) {
  const SpringNetwork network = block(varied, 100.0);
  Scene scene = automatic_scene("velocity-verlet", tick, duration);
  scene.loads = {{.face = Face::z_min,
                  .force = {0.0, 0.0, 1e-6},
                  .start = 0.0,
                  .end = 0.02,
                  .profile = Profile::half_sine}};
  const Trace motion = roll_out(context, scene, &network, {.position = true});
  const NetworkProblem problem(network, resolve_loads(scene, network));
  const Trace exact = reference::solve_modal(problem, motion.time, {});
  constexpr double omega = 500.0;
  outcome.judge_at_most(
      "velocity-verlet: error of a slow push at ratio 100",
      trajectory_error(motion.position, exact.position, problem.initial_position()).maximum,
      std::pow(omega * motion.h, 2) / 24.0 * omega * duration,
      "modal superposition; (h w)^2 / 24 w T at w = 500 rad/s");
}

void measure_contrast(Varied varied, const CaseContext& context, Outcome& outcome) {
  const char* what = varied == Varied::stiffness ? "stiffness contrast" : "mass ratio";
  Table& table =
      outcome.table("ladder", "Automatic substeps over six decades",
                    "Margin is 20 log10 of the true limit over the step taken; it is infinite "
                    "where the implicit midpoint rule was chosen.",
                    {"integrator", std::string(what) + " (1)", "substeps (1)", "step (us)",
                     "margin (dB)", "largest energy / initial (1)", "theory (1)"});
  Figure& figure =
      outcome.plot("step", std::string("Step over ") + what,
                   "Automatic substeps in a tick of 1 ms, and the limit from the exact spectrum.",
                   logarithmic(std::string(what) + " (1)"), logarithmic("step (s)"));
  for (const char* integrator : {"euler-cromer", "velocity-verlet", "auto"}) {
    std::vector<Rung> ladder;
    if (figure.series.empty()) { figure.add("true limit", Series::Style::dashed); }
    Series& steps = figure.add(integrator, Series::Style::line_and_points);
    for (int decade = 0; decade <= 6; decade += context.quick ? 2 : 1) {
      ladder.push_back(climb(context, integrator, varied, std::pow(10.0, decade)));
      steps.add(ladder.back().ratio, ladder.back().motion.h);
    }
    judge_ladder(integrator, ladder, table, outcome);
    Series& limit = figure.series.front();
    if (!limit.x.empty()) { continue; }
    for (const Rung& rung : ladder) { limit.add(rung.ratio, rung.limit); }
  }
  judge_accuracy(context, varied, outcome);
}

}  // namespace

std::vector<Case> limit_cases() {
  std::vector<Case> cases{
      {"stability/spectral-bounds", "stability",
       "the estimated and the guaranteed highest frequency of a network enclose the exact one",
       measure_bounds}};
  add_scheme_cases(
      cases, "stability/blow-up/", "stability",
      [](const IntegratorInfo& scheme) -> std::string {
        return scheme.implicit ? "no step makes a lattice blow up"
                               : "a lattice blows up at the step that its exact spectrum predicts, "
                                 "and the guaranteed step lies below it";
      },
      measure_blow_up);
  add_scheme_cases(
      cases, "stability/map/", "stability",
      [](const IntegratorInfo&) -> std::string {
        return "the border between decay and growth lies where theory puts it, at every damping";
      },
      measure_map);
  for (const Varied varied : {Varied::stiffness, Varied::mass}) {
    const bool stiffness = varied == Varied::stiffness;
    cases.push_back({stiffness ? "stability/stiffness-contrast" : "stability/mass-ratio",
                     "stability",
                     std::string("automatic substeps keep a run bounded over six decades of ") +
                         (stiffness ? "stiffness" : "mass"),
                     std::bind_front(measure_contrast, varied), 2.0});
  }
  return cases;
}

}  // namespace palpate::stability
