// SPDX-License-Identifier: MIT
/// Conservation of momentum in free networks.

#include <Eigen/Geometry>

#include "model/kernels/list_network.hpp"
#include "validation/claims/groups.hpp"
#include "validation/claims/network_fixture.hpp"

namespace palpate::networks {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

using Columns = Eigen::Map<const NodeVectors>;

/// Returns a free network with random velocities about a mean.
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
  Largest linear{};   ///< largest change over sum m |v|
  Largest angular{};  ///< over sum m |x| |v|
};

Drift drift_of(const SpringNetwork& network, const Trace& motion) {
  const auto& mass = network.mass;
  const double scale = mass.dot(network.initial_velocity.colwise().norm().transpose());
  const double reach = network.initial_position().colwise().norm().maxCoeff();
  const Vector3d p0 = momentum(mass, motion.velocity.col(0));
  const Vector3d l0 = angular_momentum(mass, motion.position.col(0), motion.velocity.col(0));
  Drift drift;
  for (Index n = 0; n < motion.velocity.cols(); ++n) {
    const auto q = motion.position.col(n);
    const auto v = motion.velocity.col(n);
    drift.linear.add((momentum(mass, v) - p0).norm() / scale);
    drift.angular.add((angular_momentum(mass, q, v) - l0).norm() / (scale * reach));
  }
  if (motion.diverged) {
    drift.linear.add(std::nan(""));
    drift.angular.add(std::nan(""));
  }
  return drift;
}

void judge_momentum(const CaseContext& context, Outcome& outcome) {
  const SpringNetwork network = free_flight(1e-3);
  const double steps = context.quick ? 400.0 : 2000.0;
  const double h = 2e-5;
  Table& table = outcome.table("momentum", "Momentum of a free, damped network",
                               "Largest change of linear and angular momentum over " + text(steps) +
                                   " steps, over the sum of all nodes' shares.",
                               {"scheme", "linear (1)", "angular (1)"});
  for (const IntegratorInfo* scheme : integrators()) {
    const std::string name(scheme->name);
    const double taken = scheme->implicit ? steps / 10.0 : steps;
    const Trace motion = roll_out(context, scene_of(name, h, taken * h), &network,
                                  {.position = true, .velocity = true});
    const Drift drift = drift_of(network, motion);
    // An implicit step ends when Newton's correction is below 64 epsilon of the velocity.
    const double per_step = (scheme->implicit ? 64.0 : 4.0) * epsilon;
    outcome.judge_at_most("momentum_drift_" + name, drift.linear.value(), taken * per_step,
                          scheme->implicit ? "64 epsilon a step: where its Newton stops"
                                           : "4 roundings of the velocity a step");
    const bool keeps_spin =
        name == "euler-cromer" || name == "feynman-newton-printed" || name == "implicit-midpoint";
    if (keeps_spin) {
      outcome.judge_at_most("angular_drift_" + name, drift.angular.value(), 4.0 * taken * per_step,
                            "theory: x' x m v' = x x m v exactly; 4 products a step");
    }
    table.rows.push_back({name, drift.linear.value(), drift.angular.value()});
  }
}

/// The kernels' forces in random states.
void judge_balance(const CaseContext& context, Outcome& outcome) {
  const SpringNetwork network = candidate(context, free_flight(1e-3));
  const NetworkProblem problem(network);
  ListNetwork<double> system(problem, {}, 1e-4, true);
  Random random(5);
  Largest force;
  Largest torque;
  for (int state = 0; state < 20; ++state) {
    const Vector<double> q = problem.initial_position() + random.vector(problem.dof(), 1e-3);
    const Vector<double> v = random.vector(problem.dof(), 0.1);
    Vector<double> f(problem.dof());
    system.force(0.0, 0.0, q, v, f);
    const Columns forces(f.data(), 3, f.size() / 3);
    const double size = forces.colwise().norm().sum();
    force.add(forces.rowwise().sum().norm() / size);
    const Vector3d about = angular_momentum(Eigen::VectorXd::Ones(f.size() / 3), q, f);
    torque.add(about.norm() / (size * q.lpNorm<Eigen::Infinity>()));
  }
  // Each of up to 26 springs of a node rounds its share once more.
  outcome.judge_at_most("internal_force_sum", force.value(), 26.0 * epsilon,
                        "Newton's third law; one rounding per spring and node");
  outcome.judge_at_most("internal_torque_sum", torque.value(), 4.0 * 26.0 * epsilon,
                        "central forces; a few roundings per spring and node");
}

void measure_momentum(const CaseContext& context, Outcome& outcome) {
  judge_momentum(context, outcome);
  judge_balance(context, outcome);
}

// Energy without loads: within the band of each scheme undamped, decreasing when damped.

/// Energy over its initial value at half the stable step of velocity Verlet.
struct EnergyRun {
  Smallest lowest{1.0};
  Largest highest{};
  std::vector<double> time{};
  std::vector<double> ratio{};
};

EnergyRun run_energy(const CaseContext& context, const SpringNetwork& network,
                     const std::string& scheme, double h, long steps) {
  const Trace motion = roll_out(context, scene_of(scheme, h, static_cast<double>(steps) * h),
                                &network, {.position = true, .energy = true});
  EnergyRun run;
  run.time = motion.time;
  for (const double energy : motion.values("energy_j")) {
    const double ratio = energy / motion.values("energy_j").front();
    run.lowest.add(ratio);
    run.highest.add(ratio);
    run.ratio.push_back(ratio);
  }
  if (motion.diverged) { run.highest.add(unbounded); }
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
  Figure& figure =
      outcome.plot("energy-undamped", "Energy of an undamped network",
                   "Symplectic schemes keep the energy in their band (omega_max h = 0.5).",
                   {"time (s)"}, {"energy / initial energy"});
  const double nonlinear = 1e-3;  // ten times the strain: the elastic energy's cubic term
  for (const Band& band : bands) {
    const std::string name = band.scheme;
    const long steps =
        name == "implicit-midpoint" ? (context.quick ? 200 : 1000) : (context.quick ? 4000 : 40000);
    const EnergyRun run = run_energy(context, network, name, h, steps);
    const std::string why =
        "theory: conserved quadratic form, and ten times the strain for the cubic term";
    outcome.judge_at_least("lowest_energy_" + name, run.lowest.value(), band.lowest(z) - nonlinear,
                           why);
    outcome.judge_at_most("highest_energy_" + name, run.highest.value(),
                          band.highest(z) + nonlinear, why);
    const std::size_t shown = std::min<std::size_t>(run.time.size(), 300);
    const auto cut = static_cast<std::ptrdiff_t>(shown);
    figure.add(name, {run.time.begin(), run.time.begin() + cut},
               {run.ratio.begin(), run.ratio.begin() + cut});
  }
}

/// Largest rise of the energy from one sample to any later one, over the initial energy.
double largest_rise(const std::vector<double>& ratio) {
  double lowest = unbounded;
  Largest rise;
  for (const double value : ratio) {
    rise.add(value - lowest);
    lowest = std::min(lowest, value);
  }
  return rise.value();
}

void judge_damped(const CaseContext& context, Outcome& outcome) {
  const SpringNetwork network = shaking(0.1, 4e-4);
  const NetworkProblem problem(network);
  const TruthSettings settings{.tolerance = {.relative = 1e-11}};
  const Truth truth = find_truth(context, problem, tick_times(2e-4, 200), settings);
  judge_truth(truth, settings, outcome);
  std::vector<double> exact;
  for (Index n = 0; n < truth.solution.position.cols(); ++n) {
    exact.push_back(problem.energy(truth.solution.position.col(n), truth.solution.velocity.col(n)));
  }
  const double initial = exact.front();
  for (double& value : exact) { value /= initial; }
  outcome.judge_at_most("largest_rise_reference", largest_rise(exact), 1e-10,
                        "theory: dampers only take energy; ten times the tolerance");
  Figure& figure = outcome.plot("energy-damped", "Energy of a damped network",
                                "Without loads the energy of a damped network only falls.",
                                {"time (s)"}, logarithmic("energy / initial energy"));
  figure.add("reference", truth.solution.time, exact, Series::Style::dashed);
  const double h = 1e-5;
  const double z = h * highest_frequency(problem);
  for (const IntegratorInfo* scheme : integrators()) {
    const std::string name(scheme->name);
    const EnergyRun run = run_energy(context, network, name, h,
                                     scheme->implicit ? (context.quick ? 100 : 500) : 4000);
    // The reported energy of a first-order scheme is its modified energy to a relative z/2.
    const bool monotone = name == "implicit-euler" || name == "rk4";
    outcome.judge_at_most(
        "largest_rise_" + name, largest_rise(run.ratio), monotone ? 1e-14 : z / 2.0,
        monotone
            ? "theory: it damps every mode; rounding"
            : "theory: the modified energy falls, and is within omega_max h / 2 of the energy");
    if (!scheme->implicit) { figure.add(name, run.time, run.ratio); }
  }
}

void measure_energy(const CaseContext& context, Outcome& outcome) {
  judge_undamped(context, outcome);
  judge_damped(context, outcome);
}

// Energy balance of the reference (exact) and of each scheme (to its order).

using Eigen::VectorXd;

constexpr double duration = 0.02;  ///< [s]

Scene loaded_scene(const std::string& scheme, long ticks, int substeps) {
  Scene scene = scene_of(scheme, duration / static_cast<double>(ticks), duration, substeps);
  scene.loads = {{.face = Face::z_min,
                  .force = {4e-3, -2e-3, 8e-3},
                  .end = duration,
                  .profile = Profile::half_sine}};
  return scene;
}

/// Power of the loads less that of the dampers [W].
double power(const NetworkProblem& problem, double t, const VectorXd& q, const VectorXd& v) {
  double sum = 0.0;
  for (const Load& load : problem.loads()) {
    for (const int node : load.nodes) {
      sum += load_factor(load, t, 0.5 * duration) *
             load.force.dot(v.segment<3>(problem.coordinate(node)));
    }
  }
  const NodeVectors held = problem.network().initial_position();
  for (const Spring& s : problem.network().springs) {
    const Index a = problem.coordinate(s.a);
    const Index b = problem.coordinate(s.b);
    const auto place = [&](Index c, int node) -> Eigen::Vector3d {
      return c < 0 ? Eigen::Vector3d(held.col(node)) : Eigen::Vector3d(q.segment<3>(c));
    };
    const auto speed = [&](Index c) -> Eigen::Vector3d {
      return c < 0 ? Eigen::Vector3d::Zero() : Eigen::Vector3d(v.segment<3>(c));
    };
    const double rate = (speed(b) - speed(a)).dot((place(b, s.b) - place(a, s.a)).normalized());
    sum -= s.viscosity * rate * rate;
  }
  return sum;
}

/// Composite Boole's rule: error O(h^6).
double integral(const std::vector<double>& values, double h) {
  constexpr std::array weight{7.0, 32.0, 12.0, 32.0};
  double sum = -7.0 * (values.front() + values.back());
  for (std::size_t n = 0; n < values.size(); ++n) {
    sum += (n % 4 == 0 ? 14.0 : weight[n % 4]) * values[n];
  }
  return sum * 2.0 * h / 45.0;
}

/// |energy change + dissipation - work| over the largest energy.
double imbalance(const NetworkProblem& problem, const Eigen::MatrixXd& position,
                 const Eigen::MatrixXd& velocity) {
  const auto samples = position.cols();
  if (samples % 4 != 1 || velocity.cols() != samples) { return std::nan(""); }
  const double h = duration / static_cast<double>(samples - 1);
  std::vector<double> powers;
  Largest peak;
  for (Index n = 0; n < samples; ++n) {
    const VectorXd q = position.col(n);
    const VectorXd v = velocity.col(n);
    powers.push_back(power(problem, static_cast<double>(n) * h, q, v));
    peak.add(problem.energy(q, v));
  }
  const double change = problem.energy(position.rightCols<1>(), velocity.rightCols<1>()) -
                        problem.energy(position.col(0), velocity.col(0));
  return std::abs(change - integral(powers, h)) / peak.value();
}

void judge_scheme(const CaseContext& context, const NetworkProblem& problem,
                  const IntegratorInfo& scheme, Figure& figure, Outcome& outcome) {
  Series& errors = figure.add(std::string(scheme.name), Series::Style::line_and_points);
  const SpringNetwork& network = problem.network();
  for (const long ticks : {128L, 256L, 512L, 1024L, 2048L}) {
    const Trace motion = roll_out(context, loaded_scene(std::string(scheme.name), ticks, 1),
                                  &network, {.position = true, .velocity = true});
    errors.add(motion.h, motion.diverged ? std::nan("")
                                         : imbalance(problem, motion.position, motion.velocity));
  }
  const ObservedOrder order = observed_order(errors.x, errors.y, 1e-12, 1.0);
  outcome.judge_at_least("order_" + std::string(scheme.name), order.slope,
                         scheme.order_damped - 0.15,
                         "theory: the balance closes at least as fast as the motion converges");
  outcome.report("imbalance_" + std::string(scheme.name), errors.y.back());
}

void measure_work(const CaseContext& context, Outcome& outcome) {
  const Block block{.nodes = {3, 3, 4}, .relaxation = 5e-4};
  SpringNetwork network = block_network(block);
  hold(network, Face::z_max);
  const NetworkProblem problem = problem_of(loaded_scene("rk4", 64, 1), network);
  constexpr long samples = 512;
  const TruthSettings settings{.tolerance = {.relative = 1e-12}};
  const Truth truth =
      find_truth(context, problem, tick_times(duration / samples, samples), settings);
  judge_truth(truth, settings, outcome);
  const double reference = imbalance(problem, truth.solution.position, truth.solution.velocity);
  outcome.judge_at_most(
      "imbalance_reference", reference, 1e-9,
      "theory; 512 samples of Boole's rule at (omega h)^6 and the reference's own tolerance");
  Figure& figure =
      outcome.plot("imbalance", "Energy balance under load",
                   "What is missing between the work of the loads, the change of energy and the "
                   "dissipation, over the largest energy; the reference is dashed.",
                   logarithmic("step (s)"), logarithmic("imbalance (1)"));
  for (const IntegratorInfo* scheme : integrators()) {
    if (scheme->implicit && context.quick) { continue; }
    judge_scheme(context, problem, *scheme, figure, outcome);
  }
  figure.add("reference", {duration / 2048, duration / 128}, {reference, reference},
             Series::Style::dashed);
}

// Independence of a motion of position, orientation and handedness of the frame, numbering, units,
// and the time at which a resting body is first loaded.

using Eigen::Matrix3d;

/// A scene with its network, whose motion is length (linear x + shift) where the base is at x.
struct Changed {
  Scene scene{};
  SpringNetwork network{};
  Matrix3d linear = Matrix3d::Identity();  ///< orthogonal
  Vector3d shift = Vector3d::Zero();
  double length = 1.0;
  std::vector<int> node_of{};  ///< base node -> node here; empty: the same
  bool exact = false;          ///< every operation maps to itself, so no rounding differs
  double reach = 0.0;          ///< largest coordinate, in units of the base [m]
};

constexpr double step = 2e-4;  ///< [s]
constexpr long steps = 200;

Changed base_case() {
  const Block block{.nodes = {4, 4, 4}};
  Changed base{.network = block_network(block)};
  hold(base.network, Face::z_max);
  displace(base.network, 0.1 * block.spacing, 11);
  Random random(12);
  base.network.springs.change_each([&](Spring& s) {
    s.stiffness *= random(0.5, 2.0);
    s.viscosity = 1e-3 * s.stiffness;
  });
  base.scene = scene_of("velocity-verlet", step, steps * step);
  base.scene.tissue.gravity = {0.5, -0.25, 9.0};
  base.scene.loads = {{.nodes = {5, 6},
                       .force = {3e-3, 2e-3, 5e-3},
                       .start = 10 * step,
                       .end = 90 * step,
                       .profile = Profile::half_sine}};
  base.reach = base.network.initial_position().cwiseAbs().maxCoeff();
  return base;
}

/// The base in another frame.
Changed moved(const Matrix3d& linear, const Vector3d& shift) {
  Changed changed = base_case();
  changed.linear = linear;
  changed.shift = shift;
  NodeVectors& rest = changed.network.rest_position;
  rest = (linear * rest).colwise() + shift;
  changed.network.springs = SpringList(changed.network.springs.listed());
  recognise_lattice(changed.network);  // in the new frame
  changed.network.initial_displacement = linear * changed.network.initial_displacement;
  changed.scene.tissue.gravity = linear * changed.scene.tissue.gravity;
  for (Load& load : changed.scene.loads) { load.force = linear * load.force; }
  changed.reach = changed.network.initial_position().cwiseAbs().maxCoeff();
  return changed;
}

Changed renumbered() {
  Changed changed = base_case();
  constexpr std::uint64_t seed = 13;
  changed.node_of = renumber(changed.network, changed.scene, seed);
  return changed;
}

/// Units of length, mass and time that are `length`, `mass` and `time` times smaller.
Changed in_units(double length, double mass, double time, bool exact) {
  Changed changed = base_case();
  changed.exact = exact;
  SpringNetwork& network = changed.network;
  network.rest_position *= length;
  network.initial_displacement *= length;
  network.mass *= mass;
  network.springs.change_each([&](Spring& s) {
    s.stiffness *= mass / (time * time);
    s.viscosity *= mass / time;
    s.rest_length *= length;
  });
  recognise_lattice(network);
  changed.scene.tissue.gravity *= length / (time * time);
  for (Load& load : changed.scene.loads) {
    load.force *= mass * length / (time * time);
    load.start *= time;
    load.end *= time;
  }
  changed.scene.simulation.step *= time;
  changed.scene.simulation.duration *= time;
  changed.length = length;
  return changed;
}

/// A body at rest, loaded `delay` steps later.
Changed delayed(long delay) {
  Changed changed = base_case();
  changed.network.initial_displacement.resize(3, 0);
  changed.scene.tissue.gravity.setZero();
  changed.scene.simulation.duration = static_cast<double>(steps + delay) * step;
  for (Load& load : changed.scene.loads) {
    load.start = static_cast<double>(10 + delay) * step;
    load.end = static_cast<double>(90 + delay) * step;
  }
  return changed;
}

/// Largest distance of the two motions over the base's peak.
double largest_difference(const Changed& base, const Trace& base_motion, const Changed& changed,
                          const Trace& motion, Index delay) {
  const NetworkProblem base_problem(base.network);
  const NetworkProblem problem(changed.network);
  if (motion.position.cols() != base_motion.position.cols() + delay) { return std::nan(""); }
  Largest largest;
  for (const int node : base_problem.free_nodes()) {
    const int there =
        changed.node_of.empty() ? node : changed.node_of[static_cast<std::size_t>(node)];
    const Index from = base_problem.coordinate(node);
    const Index to = problem.coordinate(there);
    for (Index n = 0; n < base_motion.position.cols(); ++n) {
      const Vector3d place = motion.position.col(n + delay).segment<3>(to);
      const Vector3d mapped = changed.linear.transpose() * (place - changed.shift);
      const Vector3d difference =
          mapped / changed.length - base_motion.position.col(n).segment<3>(from);
      largest.add(largest_of(difference));
    }
  }
  const auto start = base_motion.position.col(0);
  return largest.value() / largest_of(base_motion.position.colwise() - start);
}

/// Every step rounds the positions by half a unit of `reach`; through the stiffest mode that is an
/// impulse h omega_max^2 epsilon reach / 2, which moves the slowest mode by that over omega_min.
double rounding_bound(const Changed& changed, double reach, double peak) {
  const NetworkProblem problem(changed.network);
  const double fastest = highest_frequency(problem);
  constexpr double slowest = 100.0;  // [rad/s], below the first bending mode of the block
  return steps * epsilon * reach * (1.0 + step * fastest * fastest / slowest) / peak;
}

void judge(const CaseContext& context, const std::string& name, const Changed& base,
           const Changed& changed, long delay, Table& table, Outcome& outcome) {
  const Trace base_motion = roll_out(context, base.scene, &base.network, {.position = true});
  const Trace motion = roll_out(context, changed.scene, &changed.network, {.position = true});
  const double difference = largest_difference(base, base_motion, changed, motion, delay);
  const double peak = largest_of(base_motion.position.colwise() - base_motion.position.col(0));
  const double reach = std::max(base.reach, changed.reach);
  const double bound = changed.exact ? 0.0 : rounding_bound(base, reach, peak);
  outcome.judge_at_most(
      name, difference, bound,
      changed.exact ? "every operation maps to itself: the same bits"
                    : "sum of roundings of positions, from the stiffest into the slowest mode");
  table.rows.push_back({name, difference, bound});
}

void measure_invariance(const CaseContext& context, Outcome& outcome) {
  Table& table = outcome.table(
      "invariance", "Motions that must be equal",
      "Largest difference over the peak after mapping back, and its bound by rounding.",
      {"change", "difference (1)", "bound (1)"});
  const Changed base = base_case();
  const Matrix3d rotation =
      Eigen::AngleAxisd(1.1, Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
  Changed mirrored = moved(Matrix3d(Vector3d(-1.0, 1.0, 1.0).asDiagonal()), Vector3d::Zero());
  mirrored.exact = true;
  judge(context, "translated", base, moved(Matrix3d::Identity(), {0.7, -1.1, 0.4}), 0, table,
        outcome);
  judge(context, "rotated_and_translated", base, moved(rotation, {0.02, 0.03, -0.01}), 0, table,
        outcome);
  judge(context, "renumbered", base, renumbered(), 0, table, outcome);
  judge(context, "mirrored", base, mirrored, 0, table, outcome);
  judge(context, "units_mm_g_ms", base, in_units(1e3, 1e3, 1e3, false), 0, table, outcome);
  judge(context, "units_powers_of_two", base, in_units(1024.0, 512.0, 2048.0, true), 0, table,
        outcome);
  judge(context, "later_by_17_steps", delayed(0), delayed(17), 17, table, outcome);
}

}  // namespace

std::vector<Case> conservation_cases() {
  return {
      {"network/conservation/momentum", "accuracy",
       "A free network keeps its momentum to rounding, and its internal forces and torques cancel.",
       measure_momentum, 0.3},
      {"network/conservation/energy", "accuracy",
       "Undamped energy stays in the band of each symplectic scheme's theory; damped and unforced "
       "it never grows.",
       measure_energy, 1.0},
      {"network/conservation/work", "accuracy",
       "The work of the loads is the change of energy plus the dissipation, for the reference at "
       "once and for every scheme as its step falls.",
       measure_work, 1.5},
      {"network/invariance", "accuracy",
       "A motion does not depend on the frame, the numbering, the units or the clock: to the bit "
       "where arithmetic maps to itself, else to rounding.",
       measure_invariance, 0.3}};
}

}  // namespace palpate::networks
