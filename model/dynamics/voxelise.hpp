// SPDX-License-Identifier: MIT
#pragma once
/// From a closed surface to the cubic cells inside it (model/EQUATIONS.md, "Voxels of a surface").

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "model/dynamics/triangle_surface.hpp"

namespace palpate {

/// Boxes of one size in rows along x, then y, then z.
struct BoxGrid {
  Eigen::Vector3d low{0.0, 0.0, 0.0};   ///< corner of least coordinates of box (0, 0, 0) [m]
  Eigen::Vector3d size{0.0, 0.0, 0.0};  ///< edges of a box [m]
  std::array<int, 3> count{0, 0, 0};

  [[nodiscard]] std::size_t box_count() const {
    return static_cast<std::size_t>(count[0]) * static_cast<std::size_t>(count[1]) *
           static_cast<std::size_t>(count[2]);
  }
  [[nodiscard]] std::size_t index(int i, int j, int l) const {
    return (static_cast<std::size_t>(l) * static_cast<std::size_t>(count[1]) + static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(count[0]) +
           static_cast<std::size_t>(i);
  }
  [[nodiscard]] bool holds(int i, int j, int l) const {
    return i >= 0 && j >= 0 && l >= 0 && i < count[0] && j < count[1] && l < count[2];
  }
  [[nodiscard]] double volume() const { return size.prod(); }  ///< of one box [m^3]
};

/// Cubes with corners at whole multiples of `edge` [m] that cover the points.
BoxGrid cubes_around(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double edge);

struct VoxelBody {
  std::vector<std::uint8_t> inside{};  ///< per box of the grid; 1: its centre is inside the surface
  std::size_t voxel_count = 0;
  int parts = 0;        ///< that growth over 26 neighbours does not join
  double volume = 0.0;  ///< of the voxels [m^3]
};

/// The cells whose centre lies inside. Whether it does is decided row by row with the winding number of the
/// crossings before it, whose sides are exact in whole numbers of a voxel's 2^-n, so that a row through a
/// vertex or along an edge counts it once. The cells are then grown from a seed, the first cell so proved
/// inside, over 26 neighbours, and from another seed as long as there are any left.
/// The surface must have passed surface_defect.
VoxelBody voxelise(const TriangleSurface& surface, const BoxGrid& grid);

/// Volume, centroid and inertia of the cells, each a homogeneous cube.
SolidMoments moments_of(const VoxelBody& body, const BoxGrid& grid);

}  // namespace palpate
