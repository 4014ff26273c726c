// SPDX-License-Identifier: MIT
/// Steps of random length and of no length, driven through the integrator's own interface.
#include <algorithm>
#include <cmath>
#include <string>

#include "model/stepping/list_network.hpp"
#include "validation/cases/stability.hpp"
#include "validation/cases/stability_networks.hpp"

namespace palpate::stability {

namespace {

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
  double growth = 0.0;  ///< largest energy over initial
  double final = 0.0;   ///< last energy over initial
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
    if (!(result.final <= result.growth)) { result.growth = result.final; }
  }
  return result;
}

void measure_jitter(const CaseContext& context, Outcome& outcome) {
  SpringNetwork network = cube(3, relaxation);
  const Spectrum spectrum = spectrum_of(network);
  displace(network, amplitude);
  Table table{.id = "jitter",
              .title = "Random steps up to half of the stability limit",
              .columns = {"integrator", "longest step (ms)", "largest energy / initial (1)",
                          "final energy / initial (1)"}};
  for (const IntegratorInfo* scheme : integrators()) {
    const double limit = network_limit(*scheme, spectrum, relaxation).h;
    const double fastest = spectrum.omega.maxCoeff();
    const double longest = std::isfinite(limit) ? 0.5 * limit : 10.0 / fastest;
    Jittered worst;
    for (std::uint64_t seed = 1; seed <= (context.quick ? 2U : 8U); ++seed) {
      const Jittered one = jittered_run(*scheme, network, longest, 4000, seed);
      worst.growth = std::max(worst.growth, one.growth);
      worst.final = std::max(worst.final, one.final);
    }
    const std::string name(scheme->name);
    const double z = longest * fastest;
    const bool gains = scheme->name == "euler";
    outcome.judge({.name = name + ": largest energy over initial",
                   .value = worst.growth,
                   .upper = gains ? 1.0 + z : std::max(1.0 + 1e-6, energy_ratio_bound(*scheme, z)),
                   .bound_from = gains
                                     ? "potential energy gains (h w)^2 a step for a quarter period"
                                     : "what constant steps of the longest may gain on a mode; "
                                       "the dampers take what the jitter adds"});
    outcome.judge({.name = name + ": final energy over initial",
                   .value = worst.final,
                   .upper = 1.0,
                   .bound_from = "dampers only take energy"});
    table.rows.push_back({name, 1e3 * longest, worst.growth, worst.final});
  }
  outcome.tables.push_back(std::move(table));
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
    const double change =
        std::max((stage.state.position - before.position).norm() / before.position.norm(),
                 (stage.state.velocity - before.velocity).norm() / before.velocity.norm());
    const std::string name(scheme->name);
    outcome.judge({.name = name + ": relative change of the state by steps of length zero",
                   .value = change,
                   .upper = scheme->implicit ? 1e-13 : 0.0,
                   .bound_from = scheme->implicit ? "Newton's method ends at 64 roundings a step"
                                                  : "a step of length zero is no step"});
  }
}

}  // namespace

void add_step_cases(std::vector<Case>& cases) {
  cases.push_back({.name = "stability/step-jitter",
                   .suite = "stability",
                   .claim = "steps of random length below the limit feed no energy in",
                   .measure = measure_jitter});
  cases.push_back({.name = "stability/zero-step",
                   .suite = "stability",
                   .claim = "a step of length zero changes the state by no more than rounding",
                   .measure = measure_zero_step});
}

}  // namespace palpate::stability
