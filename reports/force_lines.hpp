// SPDX-License-Identifier: MIT
#pragma once
/// How force runs through a network (model/EQUATIONS.md, "Force lines").

#include "model/dynamics/problem.hpp"
#include "model/dynamics/spring_force.hpp"

namespace palpate {

struct ForceLines {
  /// Of each node: unit direction of the principal force of largest size, then that force [N], pull positive.
  Eigen::Matrix4Xf line{};
  Eigen::Vector3d held{0.0, 0.0, 0.0};  ///< elastic force of the springs on all fixed nodes [N]
};

/// `position` of all nodes [m], 3 x nodes.
ForceLines force_lines(const SpringNetwork& network, const SpringLaw& law, const NodeVectors& position);

}  // namespace palpate
