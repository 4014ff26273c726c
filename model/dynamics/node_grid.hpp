// SPDX-License-Identifier: MIT
#pragma once
/// Nodes of a network on a regular grid, of which some places may be empty.

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "model/dynamics/needle_path.hpp"

namespace palpate {

struct NodeGrid {
  Eigen::Vector3d first{0.0, 0.0, 0.0};    ///< place of node (0, 0, 0) [m]
  Eigen::Vector3d spacing{0.0, 0.0, 0.0};  ///< [m]
  std::array<int, 3> count{0, 0, 0};
  std::vector<int> node{};  ///< of the network, x fastest; -1: no node there

  [[nodiscard]] std::size_t index(int i, int j, int l) const {
    return (static_cast<std::size_t>(l) * static_cast<std::size_t>(count[1]) + static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(count[0]) +
           static_cast<std::size_t>(i);
  }
  [[nodiscard]] int at(int i, int j, int l) const { return node[index(i, j, l)]; }
  [[nodiscard]] Eigen::Vector3d place(int i, int j, int l) const {
    return first + spacing.cwiseProduct(Eigen::Vector3d(i, j, l));
  }
};

/// Gives the places that are not empty their numbers, in the order of the places.
void number_nodes(NodeGrid& grid);

/// Depth along z at which tissue begins beneath a place of the skin [m]; nothing where there is none.
std::optional<double> skin_depth(const NodeGrid& grid, const Eigen::Vector2d& at);

/// The nodes that have none above them in their column, in the order of their index.
std::vector<int> skin_nodes(const NodeGrid& grid);

/// Where the line origin + xi n crosses the planes of nodes: depth, and the nodes around it with bilinear weights.
struct PlaneCrossing {
  double depth = 0.0;  ///< [m]
  std::vector<NeedlePath::Support> supports{};
};
std::vector<PlaneCrossing> plane_crossings(const NodeGrid& grid, const Eigen::Vector3d& origin,
                                           const Eigen::Vector3d& direction);

}  // namespace palpate
