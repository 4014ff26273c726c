// SPDX-License-Identifier: MIT
/// Energy where nothing drives a network: kept in the band of each scheme's theory without damping,
/// only ever lost with it.

#include <algorithm>
#include <array>
#include <cmath>

#include "model/stepping/integrator.hpp"
#include "validation/cases/network_parts.hpp"
#include "validation/cases/network_support.hpp"

namespace palpate::networks {

namespace {

using Eigen::Index;

/// Energy over its initial value at half the stable step of velocity Verlet.
struct EnergyRun {
  double lowest = 0.0;
  double highest = 0.0;
  std::vector<double> time{};
  std::vector<double> ratio{};
};

EnergyRun run_energy(const CaseContext& context, const SpringNetwork& network,
                     const std::string& scheme, double h, long steps) {
  const Motion motion = simulate(context, scene_of(scheme, h, static_cast<double>(steps) * h),
                                 &network, {.energy = true});
  EnergyRun run{.lowest = 1.0};
  for (std::size_t n = 0; n < motion.energy.size(); ++n) {
    const double ratio = motion.energy[n] / motion.energy.front();
    run.lowest = std::isnan(ratio) ? ratio : std::min(run.lowest, ratio);
    run.highest = worse(run.highest, ratio);
    run.time.push_back(motion.time[n]);
    run.ratio.push_back(ratio);
  }
  if (motion.diverged) { run.highest = unbounded; }
  return run;
}

/// Every step of these conserves a quadratic form near the energy, so z = omega h bounds what the
/// energy of a linear oscillator can do (z = 0: it is conserved).
struct Band {
  const char* scheme;
  double (*lowest)(double z);
  double (*highest)(double z);
};

double kick_low(double z) { return (1.0 - z / 2.0) / (1.0 + z / 2.0); }
double kick_high(double z) { return (1.0 + z / 2.0) / (1.0 - z / 2.0); }
double verlet_low(double z) { return 1.0 - z * z / 4.0; }
double verlet_high(double z) { return 1.0 / (1.0 - z * z / 4.0); }
double flat(double) { return 1.0; }

constexpr std::array bands{Band{"euler-cromer", kick_low, kick_high},
                           Band{"feynman-newton-printed", kick_low, kick_high},
                           Band{"feynman-newton", verlet_low, verlet_high},
                           Band{"leapfrog", verlet_low, verlet_high},
                           Band{"velocity-verlet", verlet_low, verlet_high},
                           Band{"implicit-midpoint", flat, flat}};

/// Undamped, held, shaking a little: strains of 1e-4, so all but linear.
SpringNetwork shaking(double amplitude, double relaxation) {
  const Block block{.nodes = {4, 4, 4}, .relaxation = relaxation};
  SpringNetwork network = block_network(block);
  hold(network, Face::z_max);
  displace(network, amplitude * block.spacing, 6);
  return network;
}

void judge_undamped(const CaseContext& context, Outcome& outcome) {
  const SpringNetwork network = shaking(1e-4, 0.0);
  const double z = 0.5;
  SpringNetwork still = network;
  still.initial_displacement.resize(3, 0);
  const double h = z / highest_frequency(NetworkProblem(still));
  Figure figure{.id = "energy-undamped",
                .title = "Energy of an undamped network",
                .caption =
                    "Symplectic schemes keep the energy in the band of their theory for ever "
                    "(omega_max h = 0.5).",
                .x = {.label = "time (s)"},
                .y = {.label = "energy / initial energy"}};
  const double nonlinear = 1e-3;  // ten times the strain: the elastic energy's cubic term
  for (const Band& band : bands) {
    const std::string name = band.scheme;
    const long steps =
        name == "implicit-midpoint" ? (context.quick ? 200 : 1000) : (context.quick ? 4000 : 40000);
    const EnergyRun run = run_energy(context, network, name, h, steps);
    const std::string why =
        "theory: conserved quadratic form at omega_max h = 0.5, and ten times "
        "the strain of 1e-4 for the cubic term";
    outcome.judge({.name = "lowest_energy_" + name,
                   .value = run.lowest,
                   .lower = band.lowest(z) - nonlinear,
                   .bound_from = why});
    outcome.judge({.name = "highest_energy_" + name,
                   .value = run.highest,
                   .upper = band.highest(z) + nonlinear,
                   .bound_from = why});
    const std::size_t shown = std::min<std::size_t>(run.time.size(), 300);
    const auto cut = static_cast<std::ptrdiff_t>(shown);
    figure.series.push_back(line(name, {run.time.begin(), run.time.begin() + cut},
                                 {run.ratio.begin(), run.ratio.begin() + cut}));
  }
  outcome.figures.push_back(std::move(figure));
}

/// Largest rise of the energy from one sample to any later one, over the initial energy.
double largest_rise(const std::vector<double>& ratio) {
  double lowest = unbounded;
  double rise = 0.0;
  for (const double value : ratio) {
    rise = worse(rise, value - lowest);
    lowest = std::min(lowest, value);
  }
  return rise;
}

void judge_damped(const CaseContext& context, Outcome& outcome) {
  const SpringNetwork network = shaking(0.1, 4e-4);
  const NetworkProblem problem(network);
  const TruthSettings settings{.tolerance = {.relative = 1e-11}};
  const Truth truth = find_truth(context, problem, instants(2e-4, 200), settings);
  judge_truth(truth, settings, outcome);
  std::vector<double> exact;
  for (Index n = 0; n < truth.solution.position.cols(); ++n) {
    exact.push_back(problem.energy(truth.solution.position.col(n), truth.solution.velocity.col(n)));
  }
  const double initial = exact.front();
  for (double& value : exact) { value /= initial; }
  outcome.judge({.name = "largest_rise_reference",
                 .value = largest_rise(exact),
                 .upper = 1e-10,
                 .bound_from = "theory: dampers only take energy; ten times the tolerance"});
  Figure figure{.id = "energy-damped",
                .title = "Energy of a damped network",
                .caption = "Without loads the energy of a damped network only falls.",
                .x = {.label = "time (s)"},
                .y = {.label = "energy / initial energy", .logarithmic = true}};
  figure.series.push_back(line("reference", truth.solution.time, exact, Series::Style::dashed));
  const double h = 1e-5;
  const double z = h * highest_frequency(problem);
  for (const IntegratorInfo* scheme : integrators()) {
    const std::string name(scheme->name);
    const EnergyRun run = run_energy(context, network, name, h,
                                     scheme->implicit ? (context.quick ? 100 : 500) : 4000);
    // What a scheme reports is its modified energy to within z/2 of itself at first order.
    const bool monotone = name == "implicit-euler" || name == "rk4";
    outcome.judge({.name = "largest_rise_" + name,
                   .value = largest_rise(run.ratio),
                   .upper = monotone ? 1e-14 : z / 2.0,
                   .bound_from = monotone ? "theory: it damps every mode; rounding"
                                          : "theory: the modified energy falls, and is within "
                                            "omega_max h / 2 of the energy"});
    if (!scheme->implicit) { figure.series.push_back(line(name, run.time, run.ratio)); }
  }
  outcome.figures.push_back(std::move(figure));
}

void measure_energy(const CaseContext& context, Outcome& outcome) {
  judge_undamped(context, outcome);
  judge_damped(context, outcome);
}

}  // namespace

std::vector<Case> energy_cases() {
  return {{.name = "network/conservation/energy",
           .suite = "accuracy",
           .claim = "Undamped energy stays in the band of each symplectic scheme's theory; damped "
                    "and unforced it never grows.",
           .measure = measure_energy,
           .weight = 1.0}};
}

}  // namespace palpate::networks
