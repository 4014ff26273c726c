// SPDX-License-Identifier: MIT
/// What a motion must not depend on: place, orientation and handedness of the frame, numbering,
/// units, and the instant at which a resting body is first loaded.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>

#include "validation/cases/network_parts.hpp"
#include "validation/cases/network_support.hpp"
#include "validation/renumbering.hpp"

namespace palpate::networks {

namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A scene with its network, and how its motion maps back to that of the base.
struct Changed {
  Scene scene{};
  SpringNetwork network{};
  std::function<Vector3d(const Vector3d&)> back{};
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
  base.back = [](const Vector3d& x) { return x; };
  base.reach = base.network.initial_position().cwiseAbs().maxCoeff();
  return base;
}

void map_vectors(Changed& changed, const Matrix3d& linear, const Vector3d& shift) {
  NodeVectors& rest = changed.network.rest_position;
  rest = (linear * rest).colwise() + shift;
  changed.network.initial_displacement = linear * changed.network.initial_displacement;
  changed.scene.tissue.gravity = linear * changed.scene.tissue.gravity;
  for (Load& load : changed.scene.loads) { load.force = linear * load.force; }
  changed.reach = changed.network.initial_position().cwiseAbs().maxCoeff();
}

Changed translated() {
  Changed changed = base_case();
  const Vector3d shift(0.7, -1.1, 0.4);
  map_vectors(changed, Matrix3d::Identity(), shift);
  changed.back = [shift](const Vector3d& x) { return Vector3d(x - shift); };
  return changed;
}

Changed turned() {
  Changed changed = base_case();
  const Matrix3d rotation =
      Eigen::AngleAxisd(1.1, Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
  const Vector3d shift(0.02, 0.03, -0.01);
  map_vectors(changed, rotation, shift);
  changed.back = [rotation, shift](const Vector3d& x) {
    return Vector3d(rotation.transpose() * (x - shift));
  };
  return changed;
}

Changed mirrored() {
  Changed changed = base_case();
  const Matrix3d mirror = Vector3d(-1.0, 1.0, 1.0).asDiagonal();
  map_vectors(changed, mirror, Vector3d::Zero());
  changed.back = [](const Vector3d& x) { return Vector3d(-x.x(), x.y(), x.z()); };
  changed.exact = true;
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
  changed.scene.tissue.gravity *= length / (time * time);
  for (Load& load : changed.scene.loads) {
    load.force *= mass * length / (time * time);
    load.start *= time;
    load.end *= time;
  }
  changed.scene.simulation.step *= time;
  changed.scene.simulation.duration *= time;
  changed.back = [length](const Vector3d& x) { return Vector3d(x / length); };
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
double largest_difference(const Changed& base, const Motion& base_motion, const Changed& changed,
                          const Motion& motion, Index delay) {
  const NetworkProblem base_problem(base.network);
  const NetworkProblem problem(changed.network);
  if (motion.position.cols() != base_motion.position.cols() + delay) { return std::nan(""); }
  double largest = 0.0;
  for (const int node : base_problem.free_nodes()) {
    const int there =
        changed.node_of.empty() ? node : changed.node_of[static_cast<std::size_t>(node)];
    const Index from = base_problem.coordinate(node);
    const Index to = problem.coordinate(there);
    for (Index n = 0; n < base_motion.position.cols(); ++n) {
      const Vector3d mapped = changed.back(motion.position.col(n + delay).segment<3>(to));
      const Vector3d difference = mapped - base_motion.position.col(n).segment<3>(from);
      largest = worse(largest, largest_of(difference));
    }
  }
  const auto start = base_motion.position.col(0);
  return largest / largest_of(base_motion.position.colwise() - start);
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
  const Motion base_motion = simulate(context, base.scene, &base.network);
  const Motion motion = simulate(context, changed.scene, &changed.network);
  const double difference = largest_difference(base, base_motion, changed, motion, delay);
  const double peak = largest_of(base_motion.position.colwise() - base_motion.position.col(0));
  const double reach = std::max(base.reach, changed.reach);
  const double bound = changed.exact ? 0.0 : rounding_bound(base, reach, peak);
  outcome.judge({.name = name,
                 .value = difference,
                 .upper = bound,
                 .bound_from = changed.exact
                                   ? "every operation maps to itself: the same bits"
                                   : "rounding of positions each step, through the stiffest mode "
                                     "into the slowest, added up"});
  table.rows.push_back({name, difference, bound});
}

void measure(const CaseContext& context, Outcome& outcome) {
  Table table{.id = "invariance",
              .title = "Motions that must be equal",
              .caption =
                  "Largest difference over the peak displacement after mapping back, and the "
                  "growth that rounding allows.",
              .columns = {"change", "difference (1)", "bound (1)"}};
  const Changed base = base_case();
  judge(context, "translated", base, translated(), 0, table, outcome);
  judge(context, "rotated_and_translated", base, turned(), 0, table, outcome);
  judge(context, "renumbered", base, renumbered(), 0, table, outcome);
  judge(context, "mirrored", base, mirrored(), 0, table, outcome);
  judge(context, "units_mm_g_ms", base, in_units(1e3, 1e3, 1e3, false), 0, table, outcome);
  judge(context, "units_powers_of_two", base, in_units(1024.0, 512.0, 2048.0, true), 0, table,
        outcome);
  judge(context, "later_by_17_steps", delayed(0), delayed(17), 17, table, outcome);
  outcome.tables.push_back(std::move(table));
}

}  // namespace

std::vector<Case> invariance_cases() {
  return {{.name = "network/invariance",
           .suite = "accuracy",
           .claim = "A motion does not depend on the frame, the numbering, the units or the clock: "
                    "to the bit where arithmetic maps to itself, else to rounding.",
           .measure = measure,
           .weight = 0.3}};
}

}  // namespace palpate::networks
