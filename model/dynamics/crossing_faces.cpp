// SPDX-License-Identifier: MIT
/// Where a surface intersects itself: faces in the order of their least x are held against those that
/// their extent along x still reaches.
#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Geometry>

#include "model/dynamics/triangle_surface.hpp"

namespace palpate {

namespace {

using Eigen::Vector3d;

struct Extent {
  Vector3d low{0.0, 0.0, 0.0};
  Vector3d high{0.0, 0.0, 0.0};
};

/// Six times the volume of a tetrahedron; its sign counts where it exceeds what rounding makes of it.
struct Side {
  double value = 0.0;
  double doubt = 0.0;

  [[nodiscard]] int sign() const { return value > doubt ? 1 : value < -doubt ? -1 : 0; }
};

Side side_of(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  const Vector3d ab = b - a;
  const Vector3d ac = c - a;
  const Vector3d ad = d - a;
  constexpr double doubt = 1e-9;  // of coordinates in single precision, as most files have them
  return {ad.dot(ab.cross(ac)), doubt * ab.norm() * ac.norm() * std::max(ad.norm(), ab.norm())};
}

/// Whether the segment p to q goes from one side of a face to the other through its inside or its rim.
bool pierces(const Vector3d& p, const Vector3d& q, const std::array<Vector3d, 3>& t) {
  const int from = side_of(t[0], t[1], t[2], p).sign();
  const int to = side_of(t[0], t[1], t[2], q).sign();
  if (from * to >= 0) { return false; }
  const std::array<int, 3> round{side_of(p, q, t[0], t[1]).sign(), side_of(p, q, t[1], t[2]).sign(),
                                 side_of(p, q, t[2], t[0]).sign()};
  const auto [least, most] = std::ranges::minmax(round);
  return least * most >= 0 && (least != 0 || most != 0);
}

class Sweep {
 public:
  explicit Sweep(const TriangleSurface& surface) : surface_(surface), extents_(surface.triangle.size()) {
    for (std::size_t f = 0; f < extents_.size(); ++f) {
      const auto t = corners(static_cast<int>(f));
      extents_[f] = {t[0].cwiseMin(t[1]).cwiseMin(t[2]), t[0].cwiseMax(t[1]).cwiseMax(t[2])};
    }
  }

  std::optional<std::array<int, 2>> run() {
    std::vector<int> order(extents_.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, [&](int f) { return of(f).low.x(); });
    std::vector<int> active;
    for (const int f : order) {
      std::erase_if(active, [&](int g) { return of(g).high.x() < of(f).low.x(); });
      for (const int g : active) {
        if (near(f, g) && cross(f, g)) { return std::array{std::min(f, g), std::max(f, g)}; }
      }
      active.push_back(f);
    }
    return {};
  }

 private:
  [[nodiscard]] const Extent& of(int face) const { return extents_[static_cast<std::size_t>(face)]; }
  [[nodiscard]] std::array<Vector3d, 3> corners(int face) const {
    return {surface_.corner(face, 0), surface_.corner(face, 1), surface_.corner(face, 2)};
  }
  [[nodiscard]] bool near(int f, int g) const {
    return of(f).low.y() <= of(g).high.y() && of(g).low.y() <= of(f).high.y() && of(f).low.z() <= of(g).high.z() &&
           of(g).low.z() <= of(f).high.z();
  }
  [[nodiscard]] bool cross(int f, int g) const { return edges_pierce(f, g) || edges_pierce(g, f); }

  /// Edges of f that share no vertex with g, against g.
  [[nodiscard]] bool edges_pierce(int f, int g) const {
    const auto& face = surface_.triangle[static_cast<std::size_t>(f)];
    const auto& other = surface_.triangle[static_cast<std::size_t>(g)];
    const auto shared = [&](int vertex) { return std::ranges::find(other, vertex) != other.end(); };
    const auto t = corners(f);
    for (std::size_t n = 0; n < 3; ++n) {
      const std::size_t next = (n + 1) % 3;
      if (shared(face[n]) || shared(face[next])) { continue; }
      if (pierces(t[n], t[next], corners(g))) { return true; }
    }
    return false;
  }

  const TriangleSurface& surface_;
  std::vector<Extent> extents_;
};

}  // namespace

std::optional<std::array<int, 2>> crossing_faces(const TriangleSurface& surface) { return Sweep(surface).run(); }

}  // namespace palpate
