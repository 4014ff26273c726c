// SPDX-License-Identifier: MIT
/// What a network can neither make nor lose: momentum, and energy where nothing damps or drives it.

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>

#include "model/stepping/network_system.hpp"
#include "model/stepping/stability.hpp"
#include "validation/cases/network_parts.hpp"
#include "validation/cases/network_support.hpp"

namespace palpate::networks {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

using Columns = Eigen::Map<const NodeVectors>;

/// Flying, spinning and shaking: random velocities about a mean, nothing held.
SpringNetwork free_flight(double relaxation) {
  const Block block{.nodes = {4, 4, 4}, .relaxation = relaxation};
  SpringNetwork network = block_network(block);
  displace(network, 0.1 * block.spacing, 3);
  Random random(4);
  network.initial_velocity = NodeVectors(3, network.node_count());
  for (Index i = 0; i < network.node_count(); ++i) {
    network.initial_velocity.col(i) = Vector3d(0.3, -0.2, 0.1) + Vector3d(random.vector(3, 0.1));
  }
  return network;
}

Vector3d momentum(const Eigen::VectorXd& mass, const Eigen::Ref<const Eigen::VectorXd>& v) {
  return Columns(v.data(), 3, v.size() / 3) * mass;
}

Vector3d angular_momentum(const Eigen::VectorXd& mass, const Eigen::Ref<const Eigen::VectorXd>& q,
                          const Eigen::Ref<const Eigen::VectorXd>& v) {
  Vector3d sum = Vector3d::Zero();
  for (Index i = 0; i < mass.size(); ++i) {
    sum += mass(i) * Vector3d(q.segment<3>(3 * i)).cross(Vector3d(v.segment<3>(3 * i)));
  }
  return sum;
}

struct Drift {
  double linear = 0.0;   ///< largest change over sum m |v|
  double angular = 0.0;  ///< over sum m |x| |v|
};

Drift drift_of(const SpringNetwork& network, const Motion& motion) {
  const auto& mass = network.mass;
  const double scale = mass.dot(network.initial_velocity.colwise().norm().transpose());
  const double reach = network.initial_position().colwise().norm().maxCoeff();
  const Vector3d p0 = momentum(mass, motion.velocity.col(0));
  const Vector3d l0 = angular_momentum(mass, motion.position.col(0), motion.velocity.col(0));
  Drift drift;
  for (Index n = 0; n < motion.velocity.cols(); ++n) {
    const auto q = motion.position.col(n);
    const auto v = motion.velocity.col(n);
    drift.linear = worse(drift.linear, (momentum(mass, v) - p0).norm() / scale);
    drift.angular =
        worse(drift.angular, (angular_momentum(mass, q, v) - l0).norm() / (scale * reach));
  }
  if (motion.diverged) { drift.linear = drift.angular = std::nan(""); }
  return drift;
}

void judge_momentum(const CaseContext& context, Outcome& outcome) {
  const SpringNetwork network = free_flight(1e-3);
  const double steps = context.quick ? 400.0 : 2000.0;
  const double h = 2e-5;
  Table table{.id = "momentum",
              .title = "Momentum of a free, damped network",
              .caption = "Largest change of linear and angular momentum over " + text(steps) +
                         " steps, over the sum of all nodes' shares.",
              .columns = {"scheme", "linear (1)", "angular (1)"}};
  for (const IntegratorInfo* scheme : integrators()) {
    const std::string name(scheme->name);
    const double taken = scheme->implicit ? steps / 10.0 : steps;
    const Motion motion = simulate(context, scene_of(name, h, taken * h), &network, {.velocity = true});
    const Drift drift = drift_of(network, motion);
    // An implicit step ends when Newton's correction is below 64 epsilon of the velocity.
    const double per_step = (scheme->implicit ? 64.0 : 4.0) * epsilon;
    outcome.judge({.name = "momentum_drift_" + name, .value = drift.linear, .upper = taken * per_step,
                   .bound_from = scheme->implicit ? "64 epsilon a step: where its Newton stops"
                                                  : "4 roundings of the velocity a step"});
    const bool keeps_spin = name == "euler-cromer" || name == "feynman-newton-printed" ||
                            name == "implicit-midpoint";
    if (keeps_spin) {
      outcome.judge({.name = "angular_drift_" + name, .value = drift.angular,
                     .upper = 4.0 * taken * per_step,
                     .bound_from = "theory: x' x m v' = x x m v exactly; 4 products a step"});
    }
    table.rows.push_back({name, drift.linear, drift.angular});
  }
  outcome.tables.push_back(std::move(table));
}

/// The kernels' forces in random states.
void judge_balance(const CaseContext& context, Outcome& outcome) {
  const SpringNetwork network = candidate(context, free_flight(1e-3));
  const NetworkProblem problem(network);
  NetworkSystem<double> system(problem, {}, 1e-4, true);
  Random random(5);
  double force = 0.0;
  double torque = 0.0;
  for (int state = 0; state < 20; ++state) {
    const Vector<double> q = problem.initial_position() + random.vector(problem.dof(), 1e-3);
    const Vector<double> v = random.vector(problem.dof(), 0.1);
    Vector<double> f(problem.dof());
    system.force(0.0, 0.0, q, v, f);
    const Columns forces(f.data(), 3, f.size() / 3);
    const double size = forces.colwise().norm().sum();
    force = worse(force, forces.rowwise().sum().norm() / size);
    const Vector3d about = angular_momentum(Eigen::VectorXd::Ones(f.size() / 3), q, f);
    torque = worse(torque, about.norm() / (size * q.lpNorm<Eigen::Infinity>()));
  }
  // Each of up to 26 springs of a node rounds its share once more.
  outcome.judge({.name = "internal_force_sum", .value = force, .upper = 26.0 * epsilon,
                 .bound_from = "Newton's third law; one rounding per spring and node"});
  outcome.judge({.name = "internal_torque_sum", .value = torque, .upper = 4.0 * 26.0 * epsilon,
                 .bound_from = "central forces; a few roundings per spring and node"});
}

void measure_momentum(const CaseContext& context, Outcome& outcome) {
  judge_momentum(context, outcome);
  judge_balance(context, outcome);
}

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
                .caption = "Symplectic schemes keep the energy in the band of their theory for ever "
                           "(omega_max h = 0.5).",
                .x = {.label = "time (s)"},
                .y = {.label = "energy / initial energy"}};
  const double nonlinear = 1e-3;  // ten times the strain: the elastic energy's cubic term
  for (const Band& band : bands) {
    const std::string name = band.scheme;
    const long steps = name == "implicit-midpoint" ? (context.quick ? 200 : 1000)
                                                   : (context.quick ? 4000 : 40000);
    const EnergyRun run = run_energy(context, network, name, h, steps);
    const std::string why = "theory: conserved quadratic form at omega_max h = 0.5, and ten times "
                            "the strain of 1e-4 for the cubic term";
    outcome.judge({.name = "lowest_energy_" + name, .value = run.lowest,
                   .lower = band.lowest(z) - nonlinear, .bound_from = why});
    outcome.judge({.name = "highest_energy_" + name, .value = run.highest,
                   .upper = band.highest(z) + nonlinear, .bound_from = why});
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
  const Truth truth =
      find_truth(context, problem, instants(2e-4, 200), {.tolerance = {.relative = 1e-11}});
  std::vector<double> exact;
  for (Index n = 0; n < truth.solution.position.cols(); ++n) {
    exact.push_back(problem.energy(truth.solution.position.col(n), truth.solution.velocity.col(n)));
  }
  const double initial = exact.front();
  for (double& value : exact) { value /= initial; }
  outcome.judge({.name = "largest_rise_reference", .value = largest_rise(exact), .upper = 1e-10,
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
    const EnergyRun run = run_energy(context, network, name, h, scheme->implicit ? (context.quick ? 100 : 500) : 4000);
    // What a scheme reports is its modified energy to within z/2 of itself at first order.
    const bool monotone = name == "implicit-euler" || name == "rk4";
    outcome.judge({.name = "largest_rise_" + name, .value = largest_rise(run.ratio),
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

std::vector<Case> conservation_cases() {
  return {{.name = "network/conservation/momentum",
           .suite = "accuracy",
           .claim = "A free network keeps its momentum to rounding, and its internal forces and "
                    "torques cancel.",
           .measure = measure_momentum,
           .weight = 1.0},
          {.name = "network/conservation/energy",
           .suite = "accuracy",
           .claim = "Undamped energy stays in the band of each symplectic scheme's theory; damped "
                    "and unforced it never grows.",
           .measure = measure_energy,
           .weight = 2.0}};
}

}  // namespace palpate::networks
