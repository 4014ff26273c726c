// SPDX-License-Identifier: MIT
#pragma once
/// Regular grid of network nodes; some grid points may have no node.

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "model/problem/needle_path.hpp"
#include "model/problem/scene.hpp"
#include "model/tissue/lattice.hpp"

namespace palpate {

struct NodeGrid {
  Eigen::Vector3d first{0.0, 0.0, 0.0};    ///< position of node (0, 0, 0) [m]
  Eigen::Vector3d spacing{0.0, 0.0, 0.0};  ///< [m]
  std::array<int, 3> count{0, 0, 0};
  std::vector<int> node{};  ///< node of the network per grid point, x fastest; -1: no node

  [[nodiscard]] std::size_t index(int i, int j, int l) const { return grid_index(count, i, j, l); }
  [[nodiscard]] int at(int i, int j, int l) const { return node[index(i, j, l)]; }
  [[nodiscard]] Eigen::Vector3d place(int i, int j, int l) const {
    return first + spacing.cwiseProduct(Eigen::Vector3d(i, j, l));
  }
};

/// Numbers the existing nodes in the order of the grid points.
void number_nodes(NodeGrid& grid);

/// Returns the depth along z at which tissue begins below a point [m]; empty without tissue.
std::optional<double> skin_depth(const NodeGrid& grid, const Eigen::Vector2d& at);

/// Returns the first node of each column, x fastest; -1 for a column without nodes.
std::vector<int> skin_columns(const NodeGrid& grid);

/// Intersection of the line origin + xi n with a plane of nodes. Its nodes have bilinear weights,
/// averaged over a disc of `radius` [m] with the pressure of a rigid flat punch.
struct PlaneCrossing {
  double depth = 0.0;  ///< [m]
  std::vector<NeedlePath::Support> supports{};
};
std::vector<PlaneCrossing> plane_crossings(const NodeGrid& grid, const Eigen::Vector3d& origin,
                                           const Eigen::Vector3d& direction, double radius = 0.0);

/// Returns the block of layers below a flat skin, as close to the total thickness as possible.
LatticeShape block_shape(const Scene& scene);

/// Returns true if the layers follow a skin that need not be flat.
bool layers_follow_skin(const Scene& scene);

/// Returns true if the layers follow a skin, or if there are gaps between them.
bool layers_are_uneven(const Scene& scene);

/// Cells of a block whose centre is in tissue: below the skin, down to the bottom of a flat block
/// or of the body, and in no gap but where an inclusion is in it (model/EQUATIONS.md, "Layers
/// beneath a skin").
struct UnevenBlock {
  NodeGrid nodes{};                    ///< empty if no part of the skin is above the block
  std::vector<unsigned char> cells{};  ///< 1: tissue; x fastest
  double covered = 0.0;                ///< fraction of the block's columns that contain tissue

  [[nodiscard]] bool holds(int i, int j, int l) const {
    return cells[grid_index(cells_of(nodes.count), i, j, l)] != 0;
  }
};

/// Builds the block of a scene with uneven layers.
UnevenBlock uneven_block(const Scene& scene);

/// Returns the number of grid points of uneven_block below a skin, including empty ones.
double places_beneath_skin(const Scene& scene);

/// Returns x, y [m] of the first column of cells beneath two sheets of an open skin, and z [m] of
/// the first two intersections there: where its tissue ends is unknown. Empty if there is none.
std::optional<std::array<double, 4>> column_between_sheets(const Scene& scene);

/// Returns the grid of a tissue with grid points without nodes; empty for other tissues.
std::optional<NodeGrid> uneven_grid(const Scene& scene);

/// Returns the grid with the nodes of build_network(scene); empty for a bare network or oscillator.
std::optional<NodeGrid> tissue_grid(const Scene& scene);

struct LatticeCell {
  Eigen::Vector3d low{0.0, 0.0, 0.0};  ///< corner of least coordinates [m]
  double size = 0.0;                   ///< [m]
  double bottom = 0.0;  ///< for a flat block: z of the plane of nodes below the cell [m]

  [[nodiscard]] Eigen::Vector3d centre() const { return low.array() + 0.5 * size; }
  [[nodiscard]] Eigen::Vector3d corner(int n) const {
    return low + size * Eigen::Vector3d(n & 1, (n >> 1) & 1, n >> 2);
  }
};

/// Returns the depth of a point below the skin that the layers follow [m]; negative above it.
double depth_in_layers(const Scene& scene, const Eigen::Vector3d& point);

/// Returns the layer at a depth: the first above the skin, the last below all others.
std::size_t layer_at(const std::vector<Layer>& layers, double depth);

/// Returns the mean material over the depth of the cell. The last inclusion that contains its
/// centre sets the material. Bone is used only if all corners are in bone: it is fixed, so its
/// modulus must not act on a movable node.
CellMaterial cell_material(const Scene& scene, const LatticeCell& cell);

/// Returns true if the inclusion, enlarged by `margin` on every side, contains the point [m].
bool contains(const Inclusion& body, const Eigen::Vector3d& point, double margin = 0.0);

/// Returns true if bone contains the point, to 1e-9 m. A later inclusion of softer tissue removes
/// only its interior from the bone.
bool in_bone(const Scene& scene, const Eigen::Vector3d& point);

/// Returns true if any layer or inclusion is bone.
bool has_bone(const Scene& scene);

}  // namespace palpate
