// SPDX-License-Identifier: MIT
#pragma once
/// Closed surfaces of triangles (model/EQUATIONS.md, "Voxels of a surface").

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "model/problem/spring_network.hpp"

namespace palpate {

/// Surface of triangles with vertices in counter-clockwise order as seen from outside.
struct TriangleSurface {
  NodeVectors vertex{};  ///< [m]
  std::vector<std::array<int, 3>> triangle{};

  [[nodiscard]] Eigen::Vector3d corner(int face, int n) const {
    return vertex.col(triangle[static_cast<std::size_t>(face)][static_cast<std::size_t>(n)]);
  }
};

/// Volume, centroid and second moments of a solid of unit density.
struct SolidMoments {
  double volume = 0.0;                      ///< [m^3]; negative if the surface is inside out
  Eigen::Vector3d centroid{0.0, 0.0, 0.0};  ///< [m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the centroid [m^5]
};

/// Returns the moments of a closed surface: sums over tetrahedra from its first vertex.
SolidMoments moments_of(const TriangleSurface& surface);

/// Merges vertices of equal coordinates and removes triangles that use a vertex twice.
void weld(TriangleSurface& surface);

/// Returns the first defect of a closed surface with its place: coordinates that are not finite, a
/// missing vertex, an open edge, inconsistent orientation, intersecting faces, inside out.
std::optional<std::string> surface_defect(const TriangleSurface& surface);

}  // namespace palpate
