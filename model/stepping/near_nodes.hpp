// SPDX-License-Identifier: MIT
#pragma once
/// Which nodes about a tool, or a load, are stepped as they are, while a far field stands for the others.

#include <optional>
#include <vector>

#include "model/dynamics/problem.hpp"
#include "model/stepping/graded_lattice.hpp"

namespace palpate {

/// Of a lattice.
struct NearNodes {
  std::vector<unsigned char> near{};  ///< of each node: whether it is one
  LatticeBox box{};                   ///< around all that are
  [[nodiscard]] bool holds(int node) const { return near[static_cast<std::size_t>(node)] != 0; }
};

struct NearChoice {
  std::optional<NearNodes> nodes{};
  long far_nodes = 0;       ///< free ones
  const char* obstacle = "";  ///< why none is left to a far field
};

/// All nodes of a lattice within simulation.near_radius of those that the scene pushes.
NearChoice choose_near_nodes(const Scene& scene, const NetworkProblem& problem);

}  // namespace palpate
