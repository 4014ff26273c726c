// SPDX-License-Identifier: MIT
/// Extreme inputs: springs of zero length, inverted cells, very large forces, NaN.

#include "model/kernels/list_network.hpp"
#include "validation/bench/timing.hpp"
#include "validation/claims/groups.hpp"
#include "validation/claims/stability_fixture.hpp"
#include "validation/signal.hpp"

namespace palpate::stability {

namespace {

double largest_displacement(const Trace& motion) {
  if (!motion.position.allFinite()) { return std::nan(""); }
  return (motion.position.colwise() - motion.position.col(0)).cwiseAbs().maxCoeff();
}

/// Two equal masses `gap` apart, joined by one spring.
SpringNetwork pair(double gap, double rest_length, double stiffness) {
  SpringNetwork network;
  network.rest_position = NodeVectors::Zero(3, 2);
  network.rest_position(0, 1) = gap;
  network.mass = Eigen::VectorXd::Constant(2, 1e-3);
  network.fixed = {0, 0};
  network.springs = {{0, 1, stiffness, 0.0, rest_length}};
  return network;
}

/// Half the separation of a pair with rest length zero is x cos(w t) whatever the length passes.
void judge_through_zero(const CaseContext& context, Outcome& outcome) {
  constexpr double gap = 0.01;
  const SpringNetwork network = pair(gap, 0.0, 50.0);
  const double omega = std::sqrt(2.0 * 50.0 / 1e-3);
  const double h = 0.02 / omega;
  const Trace motion =
      roll_out(context, scene_of("velocity-verlet", h, 1000.0 * h), &network, {.position = true});
  Eigen::RowVectorXd separation = motion.position.row(3) - motion.position.row(0);
  Eigen::RowVectorXd exact(separation.size());
  const double discrete = std::acos(1.0 - 0.5 * omega * omega * h * h) / h;  // Verlet's frequency
  for (Eigen::Index n = 0; n < exact.size(); ++n) {
    exact(n) = gap * std::cos(discrete * motion.time[static_cast<std::size_t>(n)]);
  }
  outcome.judge_at_most("error of a spring that swings through zero length",
                        trajectory_error(separation, exact, Eigen::VectorXd::Zero(1)).maximum,
                        1e-10,
                        "velocity Verlet's own cosine; 1000 roundings, and no force below 1 pm");
}

void measure_zero_length(const CaseContext& context, Outcome& outcome) {
  for (const IntegratorInfo* scheme : integrators()) {
    SpringNetwork network = pair(0.0, 5e-3, 50.0);
    network.springs.change_each([](Spring& spring) { spring.viscosity = 0.01; });
    Scene scene = scene_of(std::string(scheme->name), 1e-3, 0.1);
    const Trace motion = roll_out(context, scene, &network, {.position = true});
    outcome.judge_at_most(std::string(scheme->name) + ": motion of a pair at one place",
                          largest_displacement(motion), 0.0,
                          "a spring without direction exerts no force", "m");
  }
  judge_through_zero(context, outcome);
}

/// The middle of the surface pushed one and a half cells into a 3 x 3 x 3 block.
SpringNetwork inverted_block(double relaxation) {
  SpringNetwork network = cube(3, relaxation);
  network.initial_displacement = NodeVectors::Zero(3, network.node_count());
  network.initial_displacement(2, 4) = 7.5e-3;
  return network;
}

/// The fastest mode changes as the block folds, so explicit schemes are taken at half their limit.
/// Returns the rate at which the energy of the slowest mode decays, for dampers c = relaxation k
/// [1/s].
double slowest_decay(const Spectrum& spectrum, double relaxation) {
  Smallest rate;
  for (const double omega : spectrum.omega) {
    const double a = 0.5 * relaxation * omega * omega;
    rate.add(2.0 * (a - std::sqrt(std::max(0.0, a * a - omega * omega))));
  }
  return rate.value();
}

/// Judges the loss of energy by dampers: its exponent over that of the slowest mode.
void judge_decay(Outcome& outcome, const std::string& scheme, double final_over_initial,
                 double exponent) {
  outcome.judge_at_least(scheme + ": decay of the energy over that of the slowest mode",
                         -std::log(final_over_initial) / exponent, 0.5,
                         "theory: no mode decays more slowly than the slowest; explicit Euler at "
                         "half of its limit has half of the decay");
}

double energy_bound(const IntegratorInfo& scheme, double z) {
  return scheme.implicit ? 1.0 + z * z / 12.0 : energy_ratio_bound(scheme, 1.0);
}

void measure_inverted(const CaseContext& context, Outcome& outcome) {
  Figure& figure =
      outcome.plot("energy", "Energy after a node was pushed through its cells",
                   "Undamped 3 x 3 x 3 block, energy at every tick over the initial one.",
                   {"time (s)"}, {"energy / initial (1)"});
  const double fastest = spectrum_of(inverted_block(0.0)).omega.maxCoeff();
  for (const IntegratorInfo* scheme : integrators()) {
    if (scheme->name == "euler") { continue; }  // gains energy from any undamped motion
    const SpringNetwork network = inverted_block(0.0);
    const Trace motion = roll_out(context, automatic_scene(std::string(scheme->name), 1e-3, 0.2),
                                  &network, {.position = true, .energy = true});
    Series series{.label = std::string(scheme->name), .x = motion.time};
    for (const double e : motion.values("energy_j")) {
      series.y.push_back(e / motion.values("energy_j").front());
    }
    outcome.judge_at_most(std::string(scheme->name) + ": largest energy over initial",
                          energy_growth(motion), energy_bound(*scheme, fastest * motion.h),
                          scheme->implicit
                              ? "modified energy of the scheme: (h w)^2 / 12 on the fastest mode"
                              : "quadratic form kept on the fastest mode at half the limit");
    figure.series.push_back(std::move(series));
  }
  for (const IntegratorInfo* scheme : integrators()) {
    const SpringNetwork network = inverted_block(2e-3);
    const Trace motion = roll_out(context, automatic_scene(std::string(scheme->name), 1e-3, 0.5),
                                  &network, {.position = true, .energy = true});
    const std::vector<double>& energy = motion.values("energy_j");
    judge_decay(outcome, std::string(scheme->name),
                motion.diverged ? std::nan("") : energy.back() / energy.front(),
                motion.time.back() * slowest_decay(spectrum_of(network), 2e-3));
  }
}

void measure_huge_force(const CaseContext& context, Outcome& outcome) {
  const SpringNetwork network = cube(3, 4e-4);
  Table& table =
      outcome.table("verdicts", "A force of 1 MN on a node of 1 g", "",
                    {"integrator", "verdict", "at (s)", "largest displacement seen (m)"});
  int unclear = 0;
  for (const IntegratorInfo* scheme : integrators()) {
    Scene scene = automatic_scene(std::string(scheme->name), 1e-3, 0.1);
    scene.loads = {{.nodes = {4}, .force = {0.0, 0.0, 1e6}}};
    const Trace motion = roll_out(context, scene, &network, {.position = true});
    const bool timed = motion.diverged_at > 0.0 && motion.diverged_at <= 0.1 + 1e-12;
    const bool clear = motion.position.allFinite() && (!motion.diverged || timed);
    unclear += clear ? 0 : 1;
    table.rows.push_back({scheme->name, motion.diverged ? "diverged" : "finite",
                          motion.diverged ? motion.diverged_at : 0.1,
                          largest_displacement(motion)});
  }
  outcome.judge_at_most("schemes without a clear verdict", unclear, 0.0,
                        "every sample that is kept is finite, and divergence has its time");
}

enum class Place { displacement, velocity, mass, stiffness };

SpringNetwork spoiled(Place place, double value) {
  SpringNetwork network = cube(3, 4e-4);
  network.initial_displacement = NodeVectors::Zero(3, network.node_count());
  network.initial_velocity = network.initial_displacement;
  switch (place) {
    case Place::displacement: network.initial_displacement(1, 4) = value; break;
    case Place::velocity: network.initial_velocity(1, 4) = value; break;
    case Place::mass: network.mass(4) = value; break;
    case Place::stiffness:
      network.springs.edit([&](std::vector<Spring>& all) { all[7].stiffness = value; });
      break;
  }
  return network;
}

void measure_nan(const CaseContext& context, Outcome& outcome) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double infinite = std::numeric_limits<double>::infinity();
  int runs = 0;
  int seen_at_once = 0;
  for (const IntegratorInfo* scheme : integrators()) {
    for (const Place place :
         {Place::displacement, Place::velocity, Place::mass, Place::stiffness}) {
      for (const double value : {nan, infinite}) {
        if (place == Place::mass && value == infinite) { continue; }  // just never moves
        for (const Precision precision :
             {Precision::double_precision, Precision::single_precision}) {
          const SpringNetwork network = spoiled(place, value);
          Scene scene = scene_of(std::string(scheme->name), 1e-3, 0.01, 1);
          scene.simulation.precision = precision;
          const Trace motion = roll_out(context, scene, &network, {.position = true});
          ++runs;
          seen_at_once += motion.diverged && motion.diverged_at == 1e-3 ? 1 : 0;
        }
      }
    }
  }
  outcome.judge_equal("runs reported as diverged at the first tick, of " + std::to_string(runs),
                      seen_at_once, runs, "a state that is not finite is divergence");
}

// Amplitudes below the normal range of double: nothing becomes NaN, and little becomes slow.

constexpr double denormal = 1e-310;  // [m]
constexpr double ordinary = 1e-3;    // [m]

/// A straight chain in tension, held at both ends, its free nodes moved sideways.
SpringNetwork chain(double amplitude) {
  constexpr int nodes = 40;
  SpringNetwork network;
  network.rest_position = NodeVectors::Zero(3, nodes);
  network.initial_displacement = NodeVectors::Zero(3, nodes);
  network.mass = Eigen::VectorXd::Constant(nodes, 1e-3);
  network.fixed.assign(nodes, 0);
  network.fixed.front() = network.fixed.back() = 1;
  Random random(1);
  for (int i = 0; i < nodes; ++i) {
    network.rest_position(0, i) = 0.005 * i;
    if (i > 0) { network.springs.push_back({i - 1, i, 50.0, 0.01, 0.004}); }
    if (network.is_fixed(i)) { continue; }
    for (const int axis : {1, 2}) {
      network.initial_displacement(axis, i) = random(-amplitude, amplitude);
    }
  }
  return network;
}

struct Pass {
  double growth = 0.0;   ///< largest sideways displacement over the initial one
  double seconds = 0.0;  ///< processor time
};

Pass run(const CaseContext& context, const std::string& scheme, double amplitude) {
  const SpringNetwork network = chain(amplitude);
  const double h = 1e-3;
  const long steps = context.quick ? 400 : 2000;
  const double begin = bench::seconds_on(bench::Clock::processor);
  const Trace motion = roll_out(context, scene_of(scheme, h, h * static_cast<double>(steps)),
                                &network, {.every = 20, .position = true});
  const double seconds = bench::seconds_on(bench::Clock::processor) - begin;
  Largest first;
  Largest largest;
  for (Eigen::Index row = 0; row < motion.position.rows(); ++row) {
    if (row % 3 == 0) { continue; }  // along the chain
    first.add(std::abs(motion.position(row, 0)));
    largest.add(motion.position.row(row).cwiseAbs().maxCoeff());
  }
  const bool sane = !motion.diverged && motion.position.allFinite();
  return {.growth = sane ? largest.value() / first.value() : std::nan(""), .seconds = seconds};
}

void measure_denormals(const CaseContext& context, Outcome& outcome) {
  Table& table = outcome.table("cost", "Run time at denormal amplitudes", "",
                               {"integrator", "1e-3 m (s)", "1e-310 m (s)", "slowdown (1)"});
  table.timing = true;
  constexpr double slowdown_allowed = 10.0;
  constexpr int least_runs = 3;
  constexpr int most_runs = 100;
  Largest slowest;
  for (const IntegratorInfo* scheme : integrators()) {
    const std::string name(scheme->name);
    if (name == "euler") { continue; }  // gains energy: sideways motion in tension is not damped
    Pass normal = run(context, name, ordinary);
    Pass small = run(context, name, denormal);
    // Other work and a hypervisor only add to a thread's time, so the least of many runs is the
    // cost; what is slow by itself is slow in all of them.
    for (int n = 1; n < most_runs; ++n) {
      if (n >= least_runs && small.seconds <= slowdown_allowed * normal.seconds) { break; }
      normal.seconds = std::min(normal.seconds, run(context, name, ordinary).seconds);
      small.seconds = std::min(small.seconds, run(context, name, denormal).seconds);
    }
    const double slowdown = small.seconds / normal.seconds;
    slowest.add(slowdown);
    table.rows.push_back({name, normal.seconds, small.seconds, slowdown});
    outcome.judge_at_most(name + ": largest displacement over initial at 1e-310 m", small.growth,
                          9.0, "no mode exceeds its initial amplitude; 76 modes at worst in phase");
  }
  outcome.judge_at_most("some scheme is slowed down more than tenfold (0 or 1)",
                        slowest.value() > slowdown_allowed ? 1.0 : 0.0, 0.0,
                        "design: no scene may miss its deadline by coming to rest");
  outcome.timings.push_back(
      {.name = "largest slowdown by denormals", .value = slowest.value(), .unit = "1"});
}

// Steps of random length and of no length, driven through the integrator's own interface.

constexpr double amplitude = 1e-6;   // [m]
constexpr double relaxation = 4e-4;  // [s]

/// A lattice, its system, and a scheme at its start.
struct Stage {
  NetworkProblem problem;
  ListNetwork<double> system;
  State<double> state;
  std::unique_ptr<Integrator<double>> integrator;

  Stage(const IntegratorInfo& scheme, const SpringNetwork& network, double h)
      : problem(network),
        system(problem, {}, h, true),
        state{problem.initial_position(), problem.initial_velocity()},
        integrator(scheme.make<double>()) {
    integrator->prepare(system, state, h);
    integrator->start(system, state, 0.0, h);
  }
  double energy() { return system.energy(state.position, integrator->velocity_at(state)); }
};

struct Jittered {
  Largest growth{};    ///< largest energy over initial
  double final = 0.0;  ///< last energy over initial
};

/// Steps uniform in [0, longest).
Jittered jittered_run(const IntegratorInfo& scheme, const SpringNetwork& network, double longest,
                      int steps, std::uint64_t seed) {
  Stage stage(scheme, network, longest);
  const double initial =
      stage.system.energy(stage.state.position, stage.problem.initial_velocity());
  Random random(seed);
  Jittered result;
  double t = 0.0;
  for (int n = 0; n < steps; ++n) {
    const double h = random(0.0, longest);
    stage.integrator->step(stage.system, stage.state, t, h);
    t += h;
    result.final = stage.energy() / initial;
    result.growth.add(result.final);
  }
  return result;
}

void measure_jitter(const CaseContext& context, Outcome& outcome) {
  SpringNetwork network = cube(3, relaxation);
  const Spectrum spectrum = spectrum_of(network);
  displace(network, amplitude);
  network = networks::candidate(context, std::move(network));
  constexpr int steps = 4000;
  const double decay = slowest_decay(spectrum, relaxation);
  Table& table = outcome.table("jitter", "Random steps up to half of the stability limit", "",
                               {"integrator", "longest step (ms)", "largest energy / initial (1)",
                                "final energy / initial (1)"});
  for (const IntegratorInfo* scheme : integrators()) {
    const double limit = network_limit(*scheme, spectrum, relaxation).h;
    const double fastest = spectrum.omega.maxCoeff();
    const double longest = std::isfinite(limit) ? 0.5 * limit : 10.0 / fastest;
    Largest growth;
    Largest final;
    for (std::uint64_t seed = 1; seed <= (context.quick ? 2U : 8U); ++seed) {
      const Jittered one = jittered_run(*scheme, network, longest, steps, seed);
      growth.add(one.growth.value());
      final.add(one.final);
    }
    const std::string name(scheme->name);
    const double z = longest * fastest;
    const bool gains = scheme->name == "euler";
    outcome.judge_at_most(
        name + ": largest energy over initial", growth.value(),
        gains ? 1.0 + z : std::max(1.0 + 1e-6, energy_ratio_bound(*scheme, z)),
        gains ? "potential energy gains (h w)^2 a step for a quarter period"
              : "gain of a mode by constant longest steps; dampers take what the jitter adds");
    // A long implicit step shortens the decay of a mode by 1 + (h w / 2)^2.
    const double half = scheme->implicit ? 0.5 * longest * spectrum.omega.minCoeff() : 0.0;
    judge_decay(outcome, name, final.value(), 0.5 * longest * steps * decay / (1.0 + half * half));
    table.rows.push_back({name, 1e3 * longest, growth.value(), final.value()});
  }
}

void measure_zero_step(const CaseContext& /*context*/, Outcome& outcome) {
  SpringNetwork network = cube(3, relaxation);
  displace(network, 1e-3);
  for (const IntegratorInfo* scheme : integrators()) {
    Stage stage(*scheme, network, 1e-4);
    for (int n = 0; n < 10; ++n) {
      stage.integrator->step(stage.system, stage.state, n * 1e-4, 1e-4);
    }
    const State<double> before = stage.state;
    for (int n = 0; n < 5; ++n) { stage.integrator->step(stage.system, stage.state, 1e-3, 0.0); }
    Largest change((stage.state.position - before.position).norm() / before.position.norm());
    change.add((stage.state.velocity - before.velocity).norm() / before.velocity.norm());
    const std::string name(scheme->name);
    outcome.judge_at_most(name + ": relative change of the state by steps of length zero",
                          change.value(), scheme->implicit ? 1e-13 : 0.0,
                          scheme->implicit ? "Newton's method ends at 64 roundings a step"
                                           : "a step of length zero is no step");
  }
}

// Ten million undamped steps: a symplectic scheme's energy swings within a band that theory gives,
// and what it conserves exactly moves by no more than accumulated rounding.

constexpr double z = 0.1;  // h omega
constexpr double epsilon = 2.2e-16;

/// Slope of y by least squares, times the length of the run, over the first value.
double trend(const Eigen::VectorXd& y) {
  const auto n = static_cast<double>(y.size());
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(y.size(), -0.5, 0.5);
  return x.dot(y.array().matrix() - Eigen::VectorXd::Constant(y.size(), y.mean())) /
         (n * x.squaredNorm() / n) / y(0);
}

struct Drift {
  Smallest lowest{};  ///< energy over initial
  Largest highest{};
  Eigen::VectorXd kept{};  ///< the invariant form at every sample, over its initial value
};

Drift drift_of(const IntegratorInfo& scheme, const Trace& motion) {
  const std::vector<double>& energy = motion.values("energy_j");
  const Eigen::Matrix2d form = invariant_form(scheme, z);
  Drift drift{.kept = Eigen::VectorXd(motion.position.cols())};
  for (const double e : energy) {
    drift.lowest.add(e / energy.front());
    drift.highest.add(e / energy.front());
  }
  for (Eigen::Index n = 0; n < motion.position.cols(); ++n) {
    const Eigen::Vector2d state(motion.position(0, n), motion.velocity(0, n));
    drift.kept(n) = state.dot(form * state);
  }
  drift.kept /= drift.kept(0);
  return drift;
}

void judge(const IntegratorInfo& scheme, const Trace& motion, const Drift& drift,
           Outcome& outcome) {
  const std::string name(scheme.name);
  // From (1, 0) the state runs over the ellipse of the form; its axes bound the energy.
  const double bound = energy_ratio_bound(scheme, z);
  const double steps = static_cast<double>(motion.steps);
  const double random_walk = epsilon * std::sqrt(steps);
  const bool complete = !motion.diverged;
  outcome.judge_at_most(name + ": highest energy over initial",
                        complete ? drift.highest.value() : std::nan(""), bound * (1.0 + 1e-9),
                        "axes of the quadratic form that the scheme keeps exactly");
  outcome.judge_at_least(name + ": lowest energy over initial",
                         complete ? drift.lowest.value() : std::nan(""), (1.0 - 1e-9) / bound,
                         "axes of the quadratic form that the scheme keeps exactly");
  outcome.judge_at_most(name + ": trend of what it keeps, over a random walk of rounding",
                        std::abs(trend(drift.kept)) / random_walk, 10.0,
                        "ten roundings a step, added at random: secular drift would be " +
                            std::to_string(static_cast<int>(std::sqrt(steps))) + " times more");
}

void measure_drift(const CaseContext& context, Outcome& outcome) {
  Figure& figure = outcome.plot("kept", "Change of the invariant over the run",
                                "Relative change of the quadratic form that each scheme keeps "
                                "exactly, in units of accumulated random rounding.",
                                {"steps (1)"}, {"change / (eps sqrt(steps)) (1)"});
  for (const char* name : {"euler-cromer", "feynman-newton", "feynman-newton-printed", "leapfrog",
                           "velocity-verlet", "implicit-midpoint"}) {
    const IntegratorInfo& scheme = *find_integrator(name);
    const long steps = (context.quick ? 500'000L : 10'000'000L) / (scheme.implicit ? 20 : 1);
    const int substeps = static_cast<int>(steps / 5000);
    const double tick = z * substeps;
    Scene scene = scene_of(name, tick, tick * 5000.0, substeps);
    scene.tissue.source = Source::oscillator;
    scene.tissue.oscillator = {
        .mass = 1.0, .stiffness = 1.0, .viscosity = 0.0, .displacement = 1.0, .velocity = 0.0};
    const Trace motion =
        roll_out(context, scene, {.position = true, .velocity = true, .energy = true});
    const Drift drift = drift_of(scheme, motion);
    judge(scheme, motion, drift, outcome);
    Series& series = figure.add(name);
    for (Eigen::Index n = 0; n < drift.kept.size(); n += 50) {
      series.add(static_cast<double>(n) * substeps,
                 (drift.kept(n) - 1.0) / (epsilon * std::sqrt(static_cast<double>(steps))));
    }
  }
  outcome.notes.emplace_back(
      "velocity-verlet: h^2 / 2 is rounded apart from h, which shrinks the state by some 1e-19 a "
      "step; after 1e7 steps that is still less than accumulated rounding is allowed to be");
}

/// The same for a lattice, whose modes all run at once.
void measure_network(const CaseContext& context, Outcome& outcome) {
  SpringNetwork network = cube(2, 0.0);
  const double fastest = spectrum_of(network).omega.maxCoeff();
  displace(network, 1e-7);
  const int substeps = context.quick ? 250 : 5000;
  const double tick = 0.5 / fastest * substeps;
  const Trace motion = roll_out(context, scene_of("velocity-verlet", tick, 2000.0 * tick, substeps),
                                &network, {.position = true, .energy = true});
  const Eigen::VectorXd energy =
      Eigen::Map<const Eigen::VectorXd>(motion.values("energy_j").data(),
                                        std::ssize(motion.values("energy_j"))) /
      motion.values("energy_j").front();
  const double bound = energy_ratio_bound(*find_integrator("velocity-verlet"), 0.5);
  outcome.judge_at_most("highest energy over initial",
                        motion.diverged ? std::nan("") : energy.maxCoeff(), bound * (1.0 + 1e-4),
                        "form kept by velocity Verlet on the fastest mode; strains of 2e-5");
  const double swing = std::sqrt((energy.array() - energy.mean()).square().mean());
  outcome.judge_at_most("trend of the energy over its swing", std::abs(trend(energy)) / swing,
                        5.0 * std::sqrt(12.0 / static_cast<double>(energy.size())),
                        "five standard errors of a slope through samples without trend");
}

}  // namespace

std::vector<Case> robustness_cases() {
  return {
      {"stability/zero-length", "stability",
       "a spring of zero length exerts no force, makes no NaN, and may be passed",
       measure_zero_length},
      {"stability/inverted", "stability", "a node pushed through its cells gains no energy",
       measure_inverted},
      {"stability/huge-force", "stability",
       "a force of 1 MN ends in a finite state or in divergence with its time", measure_huge_force},
      {"stability/nan-injection", "stability",
       "a value that is not finite is reported as divergence at the first tick", measure_nan},
      {"stability/denormals", "stability",
       "motion below the normal range of numbers stays bounded, without NaN", measure_denormals},
      {"stability/step-jitter", "stability",
       "steps of random length below the limit feed no energy in", measure_jitter},
      {"stability/zero-step", "stability",
       "a step of length zero changes the state by no more than rounding", measure_zero_step},
      {"stability/drift/oscillator", "stability",
       "ten million undamped steps change what a symplectic scheme keeps by no more than rounding",
       measure_drift, 4.0},
      {"stability/drift/network", "stability",
       "the energy of an undamped lattice has no trend over ten million steps", measure_network,
       2.0}};
}

}  // namespace palpate::stability
