// SPDX-License-Identifier: MIT
/// Amplitudes below the normal range of double: nothing becomes NaN, and little becomes slow.
#include <algorithm>
#include <cmath>
#include <string>

#include "validation/cases/stability.hpp"
#include "validation/cases/stability_networks.hpp"

namespace palpate::stability {

namespace {

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
  double seconds = 0.0;  ///< fastest of three
};

Pass run(const CaseContext& context, const std::string& scheme, double amplitude) {
  const SpringNetwork network = chain(amplitude);
  const double h = 1e-3;
  const long steps = context.quick ? 400 : 2000;
  Pass pass{.seconds = unbounded};
  for (int n = 0; n < 3; ++n) {
    const Motion motion = simulate(context, scene_of(scheme, h, h * static_cast<double>(steps)),
                                   &network, {.every = 20});
    pass.seconds = std::min(pass.seconds, motion.seconds);
    double first = 0.0;
    double largest = 0.0;
    for (Eigen::Index row = 0; row < motion.position.rows(); ++row) {
      if (row % 3 == 0) { continue; }  // along the chain
      first = std::max(first, std::abs(motion.position(row, 0)));
      largest = std::max(largest, motion.position.row(row).cwiseAbs().maxCoeff());
    }
    const bool sane = !motion.diverged && motion.position.allFinite();
    pass.growth = sane ? largest / first : std::nan("");
  }
  return pass;
}

void measure(const CaseContext& context, Outcome& outcome) {
  Table table{.id = "cost",
              .title = "Run time at denormal amplitudes",
              .columns = {"integrator", "1e-3 m (s)", "1e-310 m (s)", "slowdown (1)"},
              .timing = true};
  constexpr double slowdown_allowed = 10.0;
  double slowest = 0.0;
  for (const IntegratorInfo* scheme : integrators()) {
    const std::string name(scheme->name);
    if (name == "euler") { continue; }  // gains energy: sideways motion in tension is not damped
    const Pass normal = run(context, name, ordinary);
    const Pass small = run(context, name, denormal);
    const double slowdown = small.seconds / normal.seconds;
    slowest = std::max(slowest, slowdown);
    table.rows.push_back({name, normal.seconds, small.seconds, slowdown});
    outcome.judge(
        {.name = name + ": largest displacement over initial at 1e-310 m",
         .value = small.growth,
         .upper = 9.0,
         .bound_from = "no mode exceeds its initial amplitude; 76 modes at worst in phase"});
  }
  outcome.judge({.name = "some scheme is slowed down more than tenfold (0 or 1)",
                 .value = slowest > slowdown_allowed ? 1.0 : 0.0,
                 .upper = 0.0,
                 .bound_from = "design: no scene may miss its deadline by coming to rest"});
  outcome.timings.push_back(
      {.name = "largest slowdown by denormals", .value = slowest, .unit = "1"});
  outcome.tables.push_back(std::move(table));
}

}  // namespace

void add_denormal_cases(std::vector<Case>& cases) {
  cases.push_back({.name = "stability/denormals",
                   .suite = "stability",
                   .claim = "motion below the normal range of numbers stays bounded, without NaN",
                   .measure = measure});
}

}  // namespace palpate::stability
