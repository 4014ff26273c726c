// SPDX-License-Identifier: MIT
#pragma once
/// Closed surfaces of triangles, and what the divergence theorem says of the solid inside
/// (model/EQUATIONS.md, "Voxels of a surface").

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "model/problem/spring_network.hpp"

namespace palpate {

/// Triangles name their vertices counter-clockwise as seen from outside.
struct TriangleSurface {
  NodeVectors vertex{};  ///< [m]
  std::vector<std::array<int, 3>> triangle{};

  [[nodiscard]] Eigen::Vector3d corner(int face, int n) const {
    return vertex.col(triangle[static_cast<std::size_t>(face)][static_cast<std::size_t>(n)]);
  }
};

/// Volume, centroid and second moments of a solid of density one.
struct SolidMoments {
  double volume = 0.0;                                ///< [m^3]; negative: inside out
  Eigen::Vector3d centroid{0.0, 0.0, 0.0};            ///< [m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the centroid [m^5]
};

/// Exact for a closed surface: sums of tetrahedra from the surface's first vertex.
SolidMoments moments_of(const TriangleSurface& surface);

/// Joins vertices of equal coordinates and leaves out triangles that name a vertex twice.
void weld(TriangleSurface& surface);

/// The first thing that forbids an inside, in words with its vertex, edge or face (counted from 0,
/// after welding, with its place [m]): coordinates that are not finite, a missing vertex, an open
/// edge, faces turned against each other, two faces that cross, a surface that is inside out.
/// Nothing for a sound one.
std::optional<std::string> surface_defect(const TriangleSurface& surface);

/// Two faces without a common edge of which one pierces the other, beyond rounding.
std::optional<std::array<int, 2>> crossing_faces(const TriangleSurface& surface);

}  // namespace palpate
