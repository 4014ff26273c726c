// SPDX-License-Identifier: MIT
#include "model/dynamics/triangle_surface.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "reference/solids.hpp"
#include "tests/check.hpp"

namespace {

using namespace palpate;
using Eigen::Vector3d;
using reference::box_surface;
using reference::ring_surface;
using reference::sphere_surface;

bool contains(const std::optional<std::string>& text, std::string_view part) {
  return text && text->find(part) != std::string::npos;
}

TEST("a box has its volume, centroid and inertia, wherever it lies") {
  const Vector3d edges(0.02, 0.03, 0.05);
  const Vector3d low(1.0, -2.0, 0.5);
  const SolidMoments solid = moments_of(box_surface(low, low + edges));
  const double volume = edges.prod();
  // Rounding of coordinates near 2 m against edges of 0.02 m: 1e-14 relative.
  CHECK_NEAR(solid.volume, volume, 1e-13 * volume);
  CHECK_NEAR(solid.centroid, Vector3d(low + 0.5 * edges), 1e-14);
  const double xx = volume / 12.0 * (edges.y() * edges.y() + edges.z() * edges.z());
  CHECK_NEAR(solid.inertia(0, 0), xx, 1e-12 * xx);
  CHECK_NEAR(solid.inertia(0, 1), 0.0, 1e-12 * xx);
}

TEST("spheres and rings come to their volumes at second order of their faces") {
  const double sphere = 4.0 / 3.0 * std::numbers::pi;
  const double coarse = std::abs(moments_of(sphere_surface(Vector3d::Zero(), 1.0, 20)).volume - sphere);
  const double fine = std::abs(moments_of(sphere_surface(Vector3d::Zero(), 1.0, 40)).volume - sphere);
  CHECK_NEAR(std::log2(coarse / fine), 2.0, 0.05);
  // A wedge between two planes through z holds the integral of r dA over the polygon times sin(step):
  // the polygon's area times its centroid's radius, 1.
  const int steps = 24;
  const int around = 16;
  const double angle = 1.5 * std::numbers::pi;
  const double area = 0.5 * around * 0.3 * 0.3 * std::sin(2.0 * std::numbers::pi / around);
  const double exact = steps * std::sin(angle / steps) * area;
  CHECK_NEAR(moments_of(ring_surface(1.0, 0.3, angle, steps, around)).volume, exact, 1e-12 * exact);
}

TEST("sound surfaces have no defect") {
  CHECK(!surface_defect(box_surface(Vector3d::Zero(), Vector3d::Ones())));
  CHECK(!surface_defect(sphere_surface(Vector3d::Zero(), 1.0, 12)));
  CHECK(!surface_defect(ring_surface(1.0, 0.3, 2.0 * std::numbers::pi, 40, 20)));
  CHECK(!surface_defect(ring_surface(1.0, 0.3, 4.5, 40, 20)));
}

TEST("a missing face is an open edge, named with its face") {
  TriangleSurface box = box_surface(Vector3d::Zero(), Vector3d::Ones());
  box.triangle.pop_back();
  CHECK(contains(surface_defect(box), "open: edge ("));
  CHECK(contains(surface_defect(box), "has no face on its other side"));
}

TEST("a turned face is named, and a surface inside out too") {
  TriangleSurface box = box_surface(Vector3d::Zero(), Vector3d::Ones());
  std::swap(box.triangle[5][0], box.triangle[5][1]);
  CHECK(contains(surface_defect(box), "turned against each other"));
  CHECK(contains(surface_defect(box), "5"));
  TriangleSurface inverted = box_surface(Vector3d::Zero(), Vector3d::Ones());
  for (auto& face : inverted.triangle) { std::swap(face[0], face[1]); }
  CHECK(contains(surface_defect(inverted), "inside out: its volume is -1 m^3"));
}

TEST("a surface that goes through itself is named with both faces") {
  TriangleSurface two = box_surface(Vector3d::Zero(), Vector3d::Ones());
  const TriangleSurface other = box_surface(Vector3d::Constant(0.5), Vector3d::Constant(1.4));
  const int first = static_cast<int>(two.vertex.cols());
  two.vertex.conservativeResize(3, first + other.vertex.cols());
  two.vertex.rightCols(other.vertex.cols()) = other.vertex;
  for (const auto& t : other.triangle) { two.triangle.push_back({t[0] + first, t[1] + first, t[2] + first}); }
  CHECK(contains(surface_defect(two), "cross each other"));
  // Without a common point there is nothing to name: two bodies in one file.
  two.vertex.rightCols(other.vertex.cols()).array() += 2.0;
  CHECK(!surface_defect(two));
}

TEST("coordinates that are no numbers and vertices that do not exist are named") {
  TriangleSurface box = box_surface(Vector3d::Zero(), Vector3d::Ones());
  box.vertex(1, 3) = std::numeric_limits<double>::quiet_NaN();
  CHECK(contains(surface_defect(box), "vertex 3 has a coordinate that is not finite"));
  TriangleSurface other = box_surface(Vector3d::Zero(), Vector3d::Ones());
  other.triangle[2][1] = 8;
  CHECK(contains(surface_defect(other), "face 2 names vertex 8; 0 to 7"));
}

TEST("welding joins a soup of faces and drops those without area") {
  const TriangleSurface box = box_surface(Vector3d::Zero(), Vector3d::Ones());
  TriangleSurface soup;
  soup.vertex.resize(3, 3 * 12 + 3);
  for (int f = 0; f < 12; ++f) {
    for (int n = 0; n < 3; ++n) { soup.vertex.col(3 * f + n) = box.corner(f, n); }
    soup.triangle.push_back({3 * f, 3 * f + 1, 3 * f + 2});
  }
  soup.vertex.rightCols(3).setZero();
  soup.triangle.push_back({36, 37, 38});
  CHECK(contains(surface_defect(soup), "open"));
  weld(soup);
  CHECK(!surface_defect(soup));
  CHECK_NEAR(double(soup.triangle.size()), 12.0, 0.0);
}

}  // namespace
