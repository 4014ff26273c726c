// SPDX-License-Identifier: MIT
#pragma once
/// Which material fills which place of a scene's lattice or layered block
/// (model/EQUATIONS.md, "Material to springs").

#include "model/dynamics/lattice.hpp"
#include "model/dynamics/scene.hpp"

namespace palpate {

struct Cell {
  Eigen::Vector3d low{0.0, 0.0, 0.0};  ///< corner of least coordinates [m]
  double size = 0.0;                   ///< [m]
  double bottom = 0.0;                 ///< z of the plane of nodes below it, of a flat block [m]

  [[nodiscard]] Eigen::Vector3d centre() const { return low.array() + 0.5 * size; }
  [[nodiscard]] Eigen::Vector3d corner(int n) const {
    return low + size * Eigen::Vector3d(n & 1, (n >> 1) & 1, n >> 2);
  }
};

/// How deep a point lies beneath the skin that the layers follow, flat or not [m]; negative above it.
double depth_in_layers(const Scene& scene, const Eigen::Vector3d& point);

/// The layer at a depth; the first above the skin, the last below all. The scene has layers.
std::size_t layer_at(const std::vector<Layer>& layers, double depth);

/// The mean over the cell's depth of the layers that it crosses (or the lattice's material), or
/// that of the last inclusion that holds its centre. Bone counts only where all corners lie in
/// bone: it is rigid and held, so its modulus never pulls at a node that can move.
CellMaterial cell_material(const Scene& scene, const Cell& cell);

/// Whether the body, grown by `margin` on every side, holds the point [m].
bool contains(const Inclusion& body, const Eigen::Vector3d& point, double margin = 0.0);

/// Whether a layer or inclusion of bone holds the point, surfaces to 1e-9 m included. A later
/// inclusion of softer tissue takes only its inside out of bone.
bool in_bone(const Scene& scene, const Eigen::Vector3d& point);

/// Whether any layer or inclusion is of bone.
bool has_bone(const Scene& scene);

}  // namespace palpate
