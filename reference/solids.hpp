// SPDX-License-Identifier: MIT
#pragma once
/// Closed surfaces of solids whose volume is known in closed form, for what becomes of surfaces.

#include <functional>

#include "model/tissue/triangle_surface.hpp"

namespace palpate::reference {

/// A box with edges along the axes: volume exact.
TriangleSurface box_surface(const Eigen::Vector3d& low, const Eigen::Vector3d& high);

/// An octahedron divided `divisions` times along each edge and blown up: vertices lie on the
/// sphere, 8 n^2 faces.
TriangleSurface sphere_surface(const Eigen::Vector3d& centre, double radius, int divisions);

/// A disc of radius `thickness` swept by `angle` [rad] on a circle of `radius` about z: a torus for
/// 2 pi, and a letter C, closed at its ends, for less. `steps` along the circle, `around` the disc.
TriangleSurface ring_surface(double radius, double thickness, double angle, int steps, int around);

/// An open patch over |x| <= half.x, |y| <= half.y in `steps` by `steps` squares, its vertices at z
/// = height(x, y); faces look towards -z.
TriangleSurface patch_surface(const Eigen::Vector2d& half, int steps,
                              const std::function<double(double, double)>& height);

}  // namespace palpate::reference
