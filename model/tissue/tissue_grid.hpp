// SPDX-License-Identifier: MIT
#pragma once
/// Nodes of a network on a regular grid, of which some places may be empty.

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "model/problem/needle_path.hpp"
#include "model/problem/scene.hpp"
#include "model/tissue/lattice.hpp"

namespace palpate {

struct NodeGrid {
  Eigen::Vector3d first{0.0, 0.0, 0.0};    ///< place of node (0, 0, 0) [m]
  Eigen::Vector3d spacing{0.0, 0.0, 0.0};  ///< [m]
  std::array<int, 3> count{0, 0, 0};
  std::vector<int> node{};  ///< of the network, x fastest; -1: no node there

  [[nodiscard]] std::size_t index(int i, int j, int l) const {
    return (static_cast<std::size_t>(l) * static_cast<std::size_t>(count[1]) +
            static_cast<std::size_t>(j)) *
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

/// Depth along z at which tissue begins beneath a place of the skin [m]; nothing where there is
/// none.
std::optional<double> skin_depth(const NodeGrid& grid, const Eigen::Vector2d& at);

/// The nodes that have none above them in their column, in the order of their index.
std::vector<int> skin_nodes(const NodeGrid& grid);

/// Where the line origin + xi n crosses the planes of nodes: depth, and the nodes around it with
/// bilinear weights.
struct PlaneCrossing {
  double depth = 0.0;  ///< [m]
  std::vector<NeedlePath::Support> supports{};
};
std::vector<PlaneCrossing> plane_crossings(const NodeGrid& grid, const Eigen::Vector3d& origin,
                                           const Eigen::Vector3d& direction);

// The grid that the nodes of a scene's tissue lie on.

/// The block of layers as it is under a flat skin: as many cells deep as come nearest to their
/// thickness.
LatticeShape block_shape(const Scene& scene);

/// Whether layers lie beneath a skin that need not be flat.
bool layers_follow_skin(const Scene& scene);

/// The block's cells whose middle is beneath the skin, from the highest place of the skin above the
/// block down to where a flat block ends, or the body does (model/EQUATIONS.md, "Layers beneath a
/// skin").
struct BlockBeneathSkin {
  NodeGrid nodes{};  ///< without any where none of the skin lies above the block
  struct Column {
    int begin = 0;
    int end = 0;
  };
  std::vector<Column> columns{};  ///< cells of tissue, [begin, end) in planes of `nodes`; x fastest

  [[nodiscard]] bool holds(int i, int j, int l) const {
    const Column& column =
        columns[static_cast<std::size_t>(j) * static_cast<std::size_t>(nodes.count[0] - 1) +
                static_cast<std::size_t>(i)];
    return l >= column.begin && l < column.end;
  }
  /// Share of the block's columns that have tissue.
  [[nodiscard]] double covered() const;
};

/// Of a scene whose layers follow a skin and take at most `most_nodes` of scene_check.hpp.
BlockBeneathSkin block_beneath_skin(const Scene& scene);

/// Places on the grid that block_beneath_skin lays, some of them empty.
double places_beneath_skin(const Scene& scene);

/// The grid of a tissue whose skin need not be flat; nothing for others.
std::optional<NodeGrid> uneven_grid(const Scene& scene);

/// With the nodes numbered as in build_network(scene). Nothing for a bare network and an
/// oscillator.
std::optional<NodeGrid> tissue_grid(const Scene& scene);

// Which material fills which place of a scene's lattice or layered block
// (model/EQUATIONS.md, "Material to springs").

struct LatticeCell {
  Eigen::Vector3d low{0.0, 0.0, 0.0};  ///< corner of least coordinates [m]
  double size = 0.0;                   ///< [m]
  double bottom = 0.0;                 ///< z of the plane of nodes below it, of a flat block [m]

  [[nodiscard]] Eigen::Vector3d centre() const { return low.array() + 0.5 * size; }
  [[nodiscard]] Eigen::Vector3d corner(int n) const {
    return low + size * Eigen::Vector3d(n & 1, (n >> 1) & 1, n >> 2);
  }
};

/// How deep a point lies beneath the skin that the layers follow, flat or not [m]; negative above
/// it.
double depth_in_layers(const Scene& scene, const Eigen::Vector3d& point);

/// The layer at a depth; the first above the skin, the last below all. The scene has layers.
std::size_t layer_at(const std::vector<Layer>& layers, double depth);

/// The mean over the cell's depth of the layers that it crosses (or the lattice's material), or
/// that of the last inclusion that holds its centre. Bone counts only where all corners lie in
/// bone: it is rigid and held, so its modulus never pulls at a node that can move.
CellMaterial cell_material(const Scene& scene, const LatticeCell& cell);

/// Whether the body, grown by `margin` on every side, holds the point [m].
bool contains(const Inclusion& body, const Eigen::Vector3d& point, double margin = 0.0);

/// Whether a layer or inclusion of bone holds the point, surfaces to 1e-9 m included. A later
/// inclusion of softer tissue takes only its inside out of bone.
bool in_bone(const Scene& scene, const Eigen::Vector3d& point);

/// Whether any layer or inclusion is of bone.
bool has_bone(const Scene& scene);

}  // namespace palpate
