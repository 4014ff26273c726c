// SPDX-License-Identifier: MIT
#pragma once
/// Points of a surface that a tissue carries along (model/EQUATIONS.md, "A surface in the tissue").

#include <array>
#include <vector>

#include "model/dynamics/node_grid.hpp"
#include "model/dynamics/spring_network.hpp"

namespace palpate {

/// A point moves by the weighted mean of what four nodes move by.
struct EmbeddedPoint {
  std::array<int, 4> node{-1, -1, -1, -1};  ///< of the network; -1: the point lies too far off and stays
  std::array<double, 4> weight{};           ///< barycentric in a tetrahedron of its cell: >= 0, sum to one

  [[nodiscard]] bool follows() const { return node[0] >= 0; }
};

/// Points in a cell of tissue, one whose eight nodes exist, by their place in it; those outside, but within
/// `reach` spacings of a cell, by the place of the nearest cell that is nearest to them.
std::vector<EmbeddedPoint> embed(const NodeVectors& points, const NodeGrid& grid, int reach = 2);

/// Where the points are when the nodes have moved from `rest` to `position` [m].
NodeVectors carried(const NodeVectors& points, const std::vector<EmbeddedPoint>& embedded,
                    const NodeVectors& rest, const NodeVectors& position);

}  // namespace palpate
