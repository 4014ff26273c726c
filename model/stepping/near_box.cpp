// SPDX-License-Identifier: MIT
#include "model/stepping/near_box.hpp"

#include <algorithm>
#include <cmath>

#include "model/dynamics/needle_path.hpp"
#include "model/stepping/integrator.hpp"

namespace palpate {

namespace {

/// Nodes of a lattice within `radius` of those that a tool pushes, along each axis.
LatticeBox box_about(const NeedlePath& path, const LatticeShape& shape, double radius) {
  LatticeBox box{.first = shape.nodes, .last = {0, 0, 0}};
  const int cells = static_cast<int>(std::ceil(std::min(radius / shape.spacing, 1e6) - 1e-9));
  for (const NeedlePath::Knot& knot : path.knots()) {
    for (const NeedlePath::Support& support : path.supports(knot)) {
      const std::array<int, 3> at = shape.place(support.node);
      for (std::size_t n = 0; n < 3; ++n) {
        box.first[n] = std::max(0, std::min(box.first[n], at[n] - cells));
        box.last[n] = std::min(shape.nodes[n] - 1, std::max(box.last[n], at[n] + cells));
      }
    }
  }
  return box;
}

/// Why none of the tissue can be left to a far field, or null.
const char* obstacle_to_far_field(const Scene& scene, const NetworkProblem& problem) {
  const SpringNetwork& network = problem.network();
  if (!scene.needle && !scene.probe) { return "there is no tool that the rest would be far from"; }
  if (!scene.tissue.gravity.isZero()) { return "gravity pulls at what lies further away"; }
  if (network.initial_displacement.size() > 0 || network.initial_velocity.size() > 0) {
    return "the tissue does not begin at rest";
  }
  if (scene.simulation.printed.any()) { return "the printed equations are not linear about rest"; }
  const IntegratorInfo* asked = find_integrator(scene.simulation.integrator);
  if (asked != nullptr && !asked->implicit) { return "only an implicit scheme gains by it"; }
  return nullptr;
}

}  // namespace

NearChoice choose_near_box(const Scene& scene, const NetworkProblem& problem) {
  if (const char* obstacle = obstacle_to_far_field(scene, problem)) { return {.obstacle = obstacle}; }
  const std::optional<LatticeShape> shape = lattice_of(problem.network());
  if (!shape) { return {.obstacle = "only a regular lattice can"}; }
  const LatticeBox box = box_about(tool_path(scene, problem.network()), *shape, scene.simulation.near_radius);
  const auto is_far = [&](int node) { return !box.holds(shape->place(node)); };
  for (const Load& load : problem.loads()) {
    if (std::ranges::any_of(load.nodes, is_far)) { return {.obstacle = "a load acts further away"}; }
  }
  const auto far = std::ranges::count_if(problem.free_nodes(), is_far);
  if (far == 0) { return {.obstacle = "no free node lies further away"}; }
  return {.box = box, .far_nodes = far};
}

}  // namespace palpate
