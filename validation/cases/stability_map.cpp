// SPDX-License-Identifier: MIT
/// Growth per step of every scheme over step length and damping, measured by running it, with the
/// border of stability from theory and from bisection.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "validation/cases/stability.hpp"
#include "validation/cases/stability_networks.hpp"

namespace palpate::stability {

namespace {

constexpr double highest_step = 3.5;     // h omega0
constexpr double highest_damping = 2.0;  // S
constexpr double resolution = 1e-3;      // of the border
constexpr double blown_up = 1e3;

/// x'' + 2 S x' + x = 0 under a scheme.
Motion run(const CaseContext& context, const IntegratorInfo& scheme, double damping_ratio, double h,
           long steps, long every) {
  Scene scene = scene_of(std::string(scheme.name), h, h * static_cast<double>(steps));
  scene.tissue.source = Source::oscillator;
  scene.tissue.oscillator = {.mass = 1.0,
                             .stiffness = 1.0,
                             .viscosity = 2.0 * damping_ratio,
                             .displacement = 1.0,
                             .velocity = 0.3};
  return simulate(context, scene, nullptr, {.velocity = true, .every = every});
}

double size_at(const Motion& motion, Eigen::Index n) {
  return std::hypot(motion.position(0, n), motion.velocity(0, n));
}

/// log10 of the growth per step over the second half of a short run, within -1 and 1.
double log_growth(const CaseContext& context, const IntegratorInfo& scheme, double s, double h) {
  constexpr long steps = 60;
  const Motion motion = run(context, scheme, s, h, steps, 1);
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
  const Motion motion = run(context, scheme, s, h, steps, std::max(1L, steps / 20));
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
  if (!blows_up(context, scheme, s, high, steps)) {
    return std::numeric_limits<double>::infinity();
  }
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
  double largest_distance = 0.0;
};

Borders borders_of(const CaseContext& context, const IntegratorInfo& scheme) {
  Borders borders;
  for (int n = 0; n <= 200; ++n) {
    const double s = highest_damping * n / 200;
    borders.theory.x.push_back(s);
    borders.theory.y.push_back(scalar_limit(scheme, 1.0, s));
  }
  const int points = context.quick ? 5 : 11;
  for (int n = 0; n < points; ++n) {
    const double s = highest_damping * n / (points - 1);
    const double expected = scalar_limit(scheme, 1.0, s);
    if (expected == 0.0) { continue; }
    const double measured = measured_border(context, scheme, s, expected);
    borders.measured.x.push_back(s);
    borders.measured.y.push_back(measured);
    borders.largest_distance =
        std::max(borders.largest_distance, std::abs(measured / expected - 1.0));
  }
  return borders;
}

void measure(const IntegratorInfo& scheme, const CaseContext& context, Outcome& outcome) {
  Figure figure{.id = "map",
                .title = "Growth per step of " + std::string(scheme.name),
                .caption =
                    "Growth of x'' + 2 S x' + x = 0 per step, measured over 60 steps; the "
                    "points are the border found by bisection of long runs.",
                .x = {.label = "damping ratio S (1)", .minimum = 0.0, .maximum = highest_damping},
                .y = {.label = "h omega0 (1)", .minimum = 0.0, .maximum = highest_step}};
  figure.heat_map = heat_map(context, scheme);
  if (std::isinf(scalar_limit(scheme, 1.0, 0.5))) {
    // The size of a state and its energy are the same here, and A-stable schemes keep that.
    outcome.judge({.name = "largest log10 growth per step",
                   .value = *std::ranges::max_element(figure.heat_map->z),
                   .upper = 1e-9,
                   .bound_from = "A-stability: no step amplifies, at any damping"});
  } else {
    Borders borders = borders_of(context, scheme);
    outcome.judge({.name = "largest relative distance of the borders",
                   .value = borders.largest_distance,
                   .upper = 2e-3,
                   .bound_from = "closed forms and exact 2 x 2 matrices; runs resolve 0.1 %"});
    figure.series = {std::move(borders.theory), std::move(borders.measured)};
    if (scalar_limit(scheme, 1.0, 0.0) == 0.0) {
      outcome.notes.emplace_back(
          "S = 0 has no border: every step amplifies, which is judged on a "
          "lattice by stability/blow-up");
    }
  }
  outcome.figures.push_back(std::move(figure));
}

}  // namespace

void add_map_cases(std::vector<Case>& cases) {
  for (const IntegratorInfo* scheme : integrators()) {
    cases.push_back({.name = "stability/map/" + std::string(scheme->name),
                     .suite = "stability",
                     .claim = "the border between decay and growth lies where theory puts it, at "
                              "every damping",
                     .measure = [scheme](const CaseContext& context, Outcome& outcome) {
                       measure(*scheme, context, outcome);
                     }});
  }
}

}  // namespace palpate::stability
