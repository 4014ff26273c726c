// SPDX-License-Identifier: MIT
/// Inputs that no tissue gives: springs of zero length, inverted cells, enormous forces, NaN.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "model/dynamics/problem.hpp"
#include "validation/cases/stability.hpp"
#include "validation/cases/stability_networks.hpp"
#include "validation/metrics.hpp"

namespace palpate::stability {

namespace {

Scene automatic_scene(const IntegratorInfo& scheme, double duration) {
  Scene scene = scene_of(std::string(scheme.name), 1e-3, duration);
  scene.simulation.substeps.reset();
  return scene;
}

double largest_displacement(const Motion& motion) {
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
  const Motion motion = simulate(context, scene_of("velocity-verlet", h, 1000.0 * h), &network);
  Eigen::RowVectorXd separation = motion.position.row(3) - motion.position.row(0);
  Eigen::RowVectorXd exact(separation.size());
  const double discrete = std::acos(1.0 - 0.5 * omega * omega * h * h) / h;  // Verlet's frequency
  for (Eigen::Index n = 0; n < exact.size(); ++n) {
    exact(n) = gap * std::cos(discrete * motion.time[static_cast<std::size_t>(n)]);
  }
  outcome.judge(
      {.name = "error of a spring that swings through zero length",
       .value = trajectory_error(separation, exact, Eigen::VectorXd::Zero(1)).maximum,
       .upper = 1e-10,
       .bound_from = "velocity Verlet's own cosine; 1000 roundings, and no force below 1 pm"});
}

void measure_zero_length(const CaseContext& context, Outcome& outcome) {
  for (const IntegratorInfo* scheme : integrators()) {
    SpringNetwork network = pair(0.0, 5e-3, 50.0);
    network.springs.change_each([](Spring& spring) { spring.viscosity = 0.01; });
    Scene scene = scene_of(std::string(scheme->name), 1e-3, 0.1);
    const Motion motion = simulate(context, scene, &network);
    outcome.judge({.name = std::string(scheme->name) + ": motion of a pair at one place",
                   .value = largest_displacement(motion),
                   .unit = "m",
                   .upper = 0.0,
                   .bound_from = "a spring without direction exerts no force"});
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
double energy_bound(const IntegratorInfo& scheme, double z) {
  return scheme.implicit ? 1.0 + z * z / 12.0 : energy_ratio_bound(scheme, 1.0);
}

void measure_inverted(const CaseContext& context, Outcome& outcome) {
  Figure figure{.id = "energy",
                .title = "Energy after a node was pushed through its cells",
                .caption = "Undamped 3 x 3 x 3 block, energy at every tick over the initial one.",
                .x = {.label = "time (s)"},
                .y = {.label = "energy / initial (1)"}};
  const double fastest = spectrum_of(inverted_block(0.0)).omega.maxCoeff();
  for (const IntegratorInfo* scheme : integrators()) {
    if (scheme->name == "euler") { continue; }  // gains energy from any undamped motion
    const SpringNetwork network = inverted_block(0.0);
    const Motion motion =
        simulate(context, automatic_scene(*scheme, 0.2), &network, {.energy = true});
    Series series{.label = std::string(scheme->name), .x = motion.time};
    for (const double e : motion.energy) { series.y.push_back(e / motion.energy.front()); }
    const double growth = motion.diverged ? std::nan("") : *std::ranges::max_element(series.y);
    outcome.judge(
        {.name = std::string(scheme->name) + ": largest energy over initial",
         .value = growth,
         .upper = energy_bound(*scheme, fastest * motion.h),
         .bound_from = scheme->implicit
                           ? "modified energy of the scheme: (h w)^2 / 12 on the fastest mode"
                           : "quadratic form kept on the fastest mode at half the limit"});
    figure.series.push_back(std::move(series));
  }
  for (const IntegratorInfo* scheme : integrators()) {
    const SpringNetwork network = inverted_block(2e-3);
    const Motion motion =
        simulate(context, automatic_scene(*scheme, 0.5), &network, {.energy = true});
    outcome.judge(
        {.name = std::string(scheme->name) + ": final energy over initial, damped",
         .value = motion.diverged ? std::nan("") : motion.energy.back() / motion.energy.front(),
         .upper = 1.0,
         .bound_from = "dampers only take energy"});
  }
  outcome.figures.push_back(std::move(figure));
}

void measure_huge_force(const CaseContext& context, Outcome& outcome) {
  const SpringNetwork network = cube(3, 4e-4);
  Table table{.id = "verdicts",
              .title = "A force of 1 MN on a node of 1 g",
              .columns = {"integrator", "verdict", "at (s)", "largest displacement seen (m)"}};
  int unclear = 0;
  for (const IntegratorInfo* scheme : integrators()) {
    Scene scene = automatic_scene(*scheme, 0.1);
    scene.loads = {{.nodes = {4}, .force = {0.0, 0.0, 1e6}}};
    const Motion motion = simulate(context, scene, &network);
    const bool timed = motion.diverged_at > 0.0 && motion.diverged_at <= 0.1 + 1e-12;
    const bool clear = motion.position.allFinite() && (!motion.diverged || timed);
    unclear += clear ? 0 : 1;
    table.rows.push_back({std::string(scheme->name), motion.diverged ? "diverged" : "finite",
                          motion.diverged ? motion.diverged_at : 0.1,
                          largest_displacement(motion)});
  }
  outcome.judge({.name = "schemes without a clear verdict",
                 .value = static_cast<double>(unclear),
                 .upper = 0.0,
                 .bound_from = "every sample that is kept is finite, and divergence has its time"});
  outcome.tables.push_back(std::move(table));
}

enum class Place { displacement, velocity, mass, stiffness };

SpringNetwork spoiled(Place place, double value) {
  SpringNetwork network = cube(3, 4e-4);
  network.initial_displacement = NodeVectors::Zero(3, network.node_count());
  network.initial_velocity = network.initial_displacement;
  switch (place) {
    case Place::displacement:
      network.initial_displacement(1, 4) = value;
      break;
    case Place::velocity:
      network.initial_velocity(1, 4) = value;
      break;
    case Place::mass:
      network.mass(4) = value;
      break;
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
          const Motion motion = simulate(context, scene, &network);
          ++runs;
          seen_at_once += motion.diverged && motion.diverged_at == 1e-3 ? 1 : 0;
        }
      }
    }
  }
  outcome.judge({.name = "runs reported as diverged at the first tick, of " + std::to_string(runs),
                 .value = static_cast<double>(seen_at_once),
                 .lower = static_cast<double>(runs),
                 .upper = static_cast<double>(runs),
                 .bound_from = "a state that is not finite is divergence"});
}

Case abuse(const char* name, const char* claim, void (*measure)(const CaseContext&, Outcome&)) {
  return {.name = name, .suite = "stability", .claim = claim, .measure = measure};
}

}  // namespace

void add_abuse_cases(std::vector<Case>& cases) {
  cases.push_back(abuse("stability/zero-length",
                        "a spring of zero length exerts no force, makes no NaN, and may be passed",
                        measure_zero_length));
  cases.push_back(abuse("stability/inverted", "a node pushed through its cells gains no energy",
                        measure_inverted));
  cases.push_back(abuse("stability/huge-force",
                        "a force of 1 MN ends in a finite state or in divergence with its time",
                        measure_huge_force));
  cases.push_back(abuse("stability/nan-injection",
                        "a value that is not finite is reported as divergence at the first tick",
                        measure_nan));
}

}  // namespace palpate::stability
