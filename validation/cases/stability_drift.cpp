// SPDX-License-Identifier: MIT
/// Ten million undamped steps: a symplectic scheme's energy swings within a band that theory gives,
/// and what it conserves exactly moves by no more than accumulated rounding.
#include <algorithm>
#include <cmath>
#include <string>

#include "validation/cases/stability.hpp"
#include "validation/cases/stability_networks.hpp"

namespace palpate::stability {

namespace {

constexpr double z = 0.1;  // h omega
constexpr double epsilon = 2.2e-16;

Motion oscillate(const CaseContext& context, const std::string& scheme, long ticks, int substeps) {
  const double tick = z * substeps;
  Scene scene = scene_of(scheme, tick, tick * static_cast<double>(ticks), substeps);
  scene.tissue.source = Source::oscillator;
  scene.tissue.oscillator = {
      .mass = 1.0, .stiffness = 1.0, .viscosity = 0.0, .displacement = 1.0, .velocity = 0.0};
  return simulate(context, scene, nullptr, {.velocity = true, .energy = true});
}

/// Slope of y by least squares, times the length of the run, over the first value.
double trend(const Eigen::VectorXd& y) {
  const auto n = static_cast<double>(y.size());
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(y.size(), -0.5, 0.5);
  return x.dot(y.array().matrix() - Eigen::VectorXd::Constant(y.size(), y.mean())) /
         (n * x.squaredNorm() / n) / y(0);
}

struct Drift {
  double lowest = 0.0;  ///< energy over initial
  double highest = 0.0;
  Eigen::VectorXd kept{};  ///< the invariant form at every sample, over its initial value
};

Drift drift_of(const IntegratorInfo& scheme, const Motion& motion) {
  const auto [low, high] = std::ranges::minmax(motion.energy);
  const Eigen::Matrix2d form = invariant_form(scheme, z);
  Drift drift{low / motion.energy.front(), high / motion.energy.front(),
              Eigen::VectorXd(motion.position.cols())};
  for (Eigen::Index n = 0; n < motion.position.cols(); ++n) {
    const Eigen::Vector2d state(motion.position(0, n), motion.velocity(0, n));
    drift.kept(n) = state.dot(form * state);
  }
  drift.kept /= drift.kept(0);
  return drift;
}

void judge(const IntegratorInfo& scheme, const Motion& motion, const Drift& drift,
           Outcome& outcome) {
  const std::string name(scheme.name);
  // From (1, 0) the state runs over the ellipse of the form; its axes bound the energy.
  const double bound = energy_ratio_bound(scheme, z);
  const double steps = static_cast<double>(motion.steps);
  const double random_walk = epsilon * std::sqrt(steps);
  const bool complete = !motion.diverged;
  outcome.judge({.name = name + ": highest energy over initial",
                 .value = complete ? drift.highest : std::nan(""),
                 .upper = bound * (1.0 + 1e-9),
                 .bound_from = "axes of the quadratic form that the scheme keeps exactly"});
  outcome.judge({.name = name + ": lowest energy over initial",
                 .value = complete ? drift.lowest : std::nan(""),
                 .lower = (1.0 - 1e-9) / bound,
                 .bound_from = "axes of the quadratic form that the scheme keeps exactly"});
  outcome.judge({.name = name + ": trend of what it keeps, over a random walk of rounding",
                 .value = std::abs(trend(drift.kept)) / random_walk,
                 .upper = 10.0,
                 .bound_from = "ten roundings a step, added at random: secular drift would be " +
                               std::to_string(static_cast<int>(std::sqrt(steps))) + " times more"});
}

void measure(const CaseContext& context, Outcome& outcome) {
  Figure figure{.id = "kept",
                .title = "Change of the invariant over the run",
                .caption =
                    "Relative change of the quadratic form that each scheme keeps exactly, "
                    "in units of accumulated random rounding.",
                .x = {.label = "steps (1)"},
                .y = {.label = "change / (eps sqrt(steps)) (1)"}};
  for (const char* name : {"euler-cromer", "feynman-newton", "feynman-newton-printed", "leapfrog",
                           "velocity-verlet", "implicit-midpoint"}) {
    const IntegratorInfo& scheme = *find_integrator(name);
    const long steps = (context.quick ? 500'000L : 10'000'000L) / (scheme.implicit ? 20 : 1);
    const int substeps = static_cast<int>(steps / 5000);
    const Motion motion = oscillate(context, name, 5000, substeps);
    const Drift drift = drift_of(scheme, motion);
    judge(scheme, motion, drift, outcome);
    Series series{.label = name};
    for (Eigen::Index n = 0; n < drift.kept.size(); n += 50) {
      series.x.push_back(static_cast<double>(n) * substeps);
      series.y.push_back((drift.kept(n) - 1.0) / (epsilon * std::sqrt(static_cast<double>(steps))));
    }
    figure.series.push_back(std::move(series));
  }
  outcome.notes.emplace_back(
      "velocity-verlet: h^2 / 2 is rounded apart from h, which shrinks the "
      "state by some 1e-19 a step; after 1e7 steps that is still less than "
      "accumulated rounding is allowed to be");
  outcome.figures.push_back(std::move(figure));
}

/// The same for a lattice, whose modes all run at once.
void measure_network(const CaseContext& context, Outcome& outcome) {
  SpringNetwork network = cube(2, 0.0);
  const double fastest = spectrum_of(network).omega.maxCoeff();
  displace(network, 1e-7);
  const int substeps = context.quick ? 250 : 5000;
  const double tick = 0.5 / fastest * substeps;
  const Motion motion =
      simulate(context, scene_of("velocity-verlet", tick, 2000.0 * tick, substeps), &network,
               {.energy = true});
  const Eigen::VectorXd energy =
      Eigen::Map<const Eigen::VectorXd>(motion.energy.data(), std::ssize(motion.energy)) /
      motion.energy.front();
  const double bound = energy_ratio_bound(*find_integrator("velocity-verlet"), 0.5);
  outcome.judge(
      {.name = "highest energy over initial",
       .value = motion.diverged ? std::nan("") : energy.maxCoeff(),
       .upper = bound * (1.0 + 1e-4),
       .bound_from = "form kept by velocity Verlet on the fastest mode; strains of 2e-5"});
  const double swing = std::sqrt((energy.array() - energy.mean()).square().mean());
  outcome.judge({.name = "trend of the energy over its swing",
                 .value = std::abs(trend(energy)) / swing,
                 .upper = 5.0 * std::sqrt(12.0 / static_cast<double>(energy.size())),
                 .bound_from = "five standard errors of a slope through samples without trend"});
}

}  // namespace

void add_drift_cases(std::vector<Case>& cases) {
  cases.push_back({.name = "stability/drift/oscillator",
                   .suite = "stability",
                   .claim =
                       "ten million undamped steps change what a symplectic scheme keeps by no "
                       "more than rounding",
                   .measure = measure,
                   .weight = 4.0});
  cases.push_back({.name = "stability/drift/network",
                   .suite = "stability",
                   .claim = "the energy of an undamped lattice has no trend over ten million steps",
                   .measure = measure_network,
                   .weight = 2.0});
}

}  // namespace palpate::stability
