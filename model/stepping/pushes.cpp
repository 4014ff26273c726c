// SPDX-License-Identifier: MIT
#include "model/stepping/pushes.hpp"

#include <utility>

namespace palpate {

namespace {

class Pushes {
 public:
  explicit Pushes(const NetworkProblem& problem) : problem_(problem) {}

  void add(const NeedlePath& path) {
    for (const NeedlePath::Knot& knot : path.knots()) {
      std::vector<NeedlePath::Support> on;
      for (const NeedlePath::Support& support : path.supports(knot)) { add_free(support, on); }
      for (int axis = 0; axis < 3; ++axis) { add(on, Eigen::Vector3d::Unit(axis)); }
    }
  }
  void add(const Load& load) {
    if (load.force.isZero(0.0)) { return; }
    std::vector<NeedlePath::Support> on;
    for (const int node : load.nodes) { add_free({.node = node, .weight = 1.0}, on); }
    add(std::move(on), load.force.normalized());
  }
  std::vector<Push> take() { return std::move(pushes_); }

 private:
  void add_free(const NeedlePath::Support& support, std::vector<NeedlePath::Support>& on) const {
    if (problem_.coordinate(support.node) >= 0) { on.push_back(support); }
  }
  void add(std::vector<NeedlePath::Support> on, const Eigen::Vector3d& direction) {
    if (!on.empty()) { pushes_.push_back({.on = std::move(on), .direction = direction}); }
  }

  const NetworkProblem& problem_;
  std::vector<Push> pushes_{};
};

}  // namespace

std::vector<Push> pushes_of(const Scene& scene, const NetworkProblem& problem) {
  Pushes pushes(problem);
  if (scene.needle || scene.probe) { pushes.add(tool_path(scene, problem.network())); }
  for (const Load& load : problem.loads()) { pushes.add(load); }
  return pushes.take();
}

std::vector<int> nodes_of_tool(const Scene& scene, const SpringNetwork& network) {
  std::vector<int> nodes;
  if (!scene.needle && !scene.probe) { return nodes; }
  const NeedlePath path = tool_path(scene, network);
  for (const NeedlePath::Knot& knot : path.knots()) {
    for (const NeedlePath::Support& support : path.supports(knot)) { nodes.push_back(support.node); }
  }
  return nodes;
}

}  // namespace palpate
