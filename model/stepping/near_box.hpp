// SPDX-License-Identifier: MIT
#pragma once
/// Which nodes about a tool are stepped as they are, while a far field stands for the others.

#include <optional>

#include "model/dynamics/problem.hpp"
#include "model/stepping/graded_lattice.hpp"

namespace palpate {

struct NearChoice {
  std::optional<LatticeBox> box{};
  long far_nodes = 0;       ///< free ones
  const char* obstacle = "";  ///< why there is no box
};

/// All nodes of a lattice within simulation.near_radius, along each axis, of those that the scene's tool pushes.
NearChoice choose_near_box(const Scene& scene, const NetworkProblem& problem);

}  // namespace palpate
