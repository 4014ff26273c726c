// SPDX-License-Identifier: MIT
#pragma once
/// Where a scene pushes its tissue, and which way.

#include <vector>

#include <Eigen/Core>

#include "model/dynamics/needle_path.hpp"
#include "model/dynamics/problem.hpp"

namespace palpate {

/// A force that a scene may put on its tissue.
struct Push {
  std::vector<NeedlePath::Support> on{};  ///< free nodes, each with its part of the force
  Eigen::Vector3d direction{};            ///< of length 1
};

/// Along x, y and z at every knot of the scene's tool, and what its loads pull at; where no free node is, there is none.
std::vector<Push> pushes_of(const Scene& scene, const NetworkProblem& problem);

/// Nodes that the scene's tool may push, fixed ones too; some several times.
std::vector<int> nodes_of_tool(const Scene& scene, const SpringNetwork& network);

}  // namespace palpate
