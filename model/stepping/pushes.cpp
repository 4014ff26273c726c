// SPDX-License-Identifier: MIT
#include "model/stepping/pushes.hpp"

namespace palpate {

namespace {

void add_tool(const NeedlePath& path, std::vector<Push>& pushes) {
  for (const NeedlePath::Knot& knot : path.knots()) {
    const auto supports = path.supports(knot);
    for (int axis = 0; axis < 3; ++axis) {
      pushes.push_back({.on = {supports.begin(), supports.end()}, .direction = Eigen::Vector3d::Unit(axis)});
    }
  }
}

void add_load(const Load& load, std::vector<Push>& pushes) {
  if (load.force.isZero() || load.nodes.empty()) { return; }
  Push push{.direction = load.force.normalized()};
  for (const int node : load.nodes) { push.on.push_back({.node = node, .weight = 1.0}); }
  pushes.push_back(std::move(push));
}

}  // namespace

std::vector<Push> pushes_of(const Scene& scene, const NetworkProblem& problem) {
  std::vector<Push> pushes;
  if (scene.needle || scene.probe) { add_tool(tool_path(scene, problem.network()), pushes); }
  for (const Load& load : problem.loads()) { add_load(load, pushes); }
  return pushes;
}

}  // namespace palpate
