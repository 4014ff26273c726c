// SPDX-License-Identifier: MIT
#include "model/stepping/near_nodes.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "model/stepping/pushes.hpp"

namespace palpate {

namespace {

using Place = std::array<int, 3>;

/// `radius` in spacings.
void add_ball(const LatticeShape& shape, const Place& middle, double radius, NearNodes& nodes) {
  const double most = radius * radius * (1.0 + 1e-9);
  Place first{};
  Place last{};
  for (std::size_t n = 0; n < 3; ++n) {
    const int cells = static_cast<int>(std::min(std::sqrt(most), static_cast<double>(shape.nodes[n])));
    first[n] = std::max(0, middle[n] - cells);
    last[n] = std::min(shape.nodes[n] - 1, middle[n] + cells);
    nodes.box.first[n] = std::min(nodes.box.first[n], first[n]);
    nodes.box.last[n] = std::max(nodes.box.last[n], last[n]);
  }
  const auto square = [](int from, int to) { return static_cast<double>(to - from) * (to - from); };
  for (int l = first[2]; l <= last[2]; ++l) {
    for (int j = first[1]; j <= last[1]; ++j) {
      const double beside = square(l, middle[2]) + square(j, middle[1]);
      for (int i = first[0]; i <= last[0]; ++i) {
        if (beside + square(i, middle[0]) <= most) { nodes.near[static_cast<std::size_t>(shape.index(i, j, l))] = 1; }
      }
    }
  }
}

/// Nodes of a lattice within `radius` [m] of those that are pushed.
NearNodes nodes_about(const std::vector<Push>& pushes, const LatticeShape& shape, double radius) {
  NearNodes nodes{.near = std::vector<unsigned char>(static_cast<std::size_t>(shape.node_count())),
                  .box = {.first = shape.nodes, .last = {0, 0, 0}}};
  std::set<int> pushed;
  for (const Push& push : pushes) {
    for (const NeedlePath::Support& support : push.on) { pushed.insert(support.node); }
  }
  for (const int node : pushed) { add_ball(shape, shape.place(node), radius / shape.spacing, nodes); }
  return nodes;
}

/// Why none of the tissue can be left to a far field, or null.
const char* obstacle_to_far_field(const Scene& scene, const NetworkProblem& problem) {
  const SpringNetwork& network = problem.network();
  if (problem.dof() == 3 * network.node_count()) { return "nothing is fixed that what lies further away could rest on"; }
  if (!scene.tissue.gravity.isZero()) { return "gravity pulls at what lies further away"; }
  if (network.initial_displacement.size() > 0 || network.initial_velocity.size() > 0) {
    return "the tissue does not begin at rest";
  }
  if (scene.simulation.printed.any()) { return "the printed equations are not linear about rest"; }
  return nullptr;
}

}  // namespace

NearChoice choose_near_nodes(const Scene& scene, const NetworkProblem& problem) {
  if (const char* obstacle = obstacle_to_far_field(scene, problem)) { return {.obstacle = obstacle}; }
  const std::optional<LatticeShape> shape = lattice_of(problem.network());
  if (!shape) { return {.obstacle = "only a regular lattice can"}; }
  const std::vector<Push> pushes = pushes_of(scene, problem);
  if (pushes.empty()) { return {.obstacle = "neither tool nor load pushes a free node that the rest would be far from"}; }
  NearNodes nodes = nodes_about(pushes, *shape, scene.simulation.near_radius);
  const auto is_far = [&](int node) { return !nodes.holds(node); };
  const auto far = std::ranges::count_if(problem.free_nodes(), is_far);
  if (far == 0) { return {.obstacle = "no free node lies further away"}; }
  return {.nodes = std::move(nodes), .far_nodes = far};
}

}  // namespace palpate
