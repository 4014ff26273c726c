// SPDX-License-Identifier: MIT
#pragma once
/// Closed surfaces of solids whose volume is known in closed form.

#include <functional>

#include "model/tissue/triangle_surface.hpp"

namespace palpate {

/// Returns a box with edges along the axes; its volume is exact.
TriangleSurface box_surface(const Eigen::Vector3d& low, const Eigen::Vector3d& high);

/// Returns an octahedron with `divisions` n per edge, projected to a sphere: 8 n^2 faces with all
/// vertices on the sphere.
TriangleSurface sphere_surface(const Eigen::Vector3d& centre, double radius, int divisions);

/// Returns a disc of radius `thickness` [m] swept by `angle` [rad] on a circle of `radius` [m]
/// about z: a torus for 2 pi, else an arc with closed ends. It has `steps` divisions along the
/// circle and `around` along the disc.
TriangleSurface ring_surface(double radius, double thickness, double angle, int steps, int around);

/// Returns an open patch over |x| <= half.x, |y| <= half.y in `steps` by `steps` squares, with
/// vertices at z = height(x, y). Normals point towards -z.
TriangleSurface patch_surface(const Eigen::Vector2d& half, int steps,
                              const std::function<double(double, double)>& height);

}  // namespace palpate
