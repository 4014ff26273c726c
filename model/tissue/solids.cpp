// SPDX-License-Identifier: MIT

#include "model/tissue/solids.hpp"

#include <cmath>
#include <numbers>

namespace palpate {

namespace {

using Eigen::Vector3d;

class Builder {
 public:
  int vertex(const Vector3d& at) {
    places_.push_back(at);
    return static_cast<int>(places_.size()) - 1;
  }
  void face(int a, int b, int c) { surface_.triangle.push_back({a, b, c}); }
  void quad(int a, int b, int c, int d) {
    face(a, b, c);
    face(a, c, d);
  }
  TriangleSurface take() {
    surface_.vertex.resize(3, static_cast<Eigen::Index>(places_.size()));
    for (std::size_t i = 0; i < places_.size(); ++i) {
      surface_.vertex.col(static_cast<Eigen::Index>(i)) = places_[i];
    }
    weld(surface_);
    return surface_;
  }

 private:
  std::vector<Vector3d> places_;
  TriangleSurface surface_;
};

}  // namespace

TriangleSurface box_surface(const Vector3d& low, const Vector3d& high) {
  Builder b;
  for (int n = 0; n < 8; ++n) {
    b.vertex({n & 1 ? high.x() : low.x(), n & 2 ? high.y() : low.y(), n & 4 ? high.z() : low.z()});
  }
  b.quad(0, 2, 3, 1);
  b.quad(4, 5, 7, 6);
  b.quad(0, 1, 5, 4);
  b.quad(2, 6, 7, 3);
  b.quad(0, 4, 6, 2);
  b.quad(1, 3, 7, 5);
  return b.take();
}

TriangleSurface sphere_surface(const Vector3d& centre, double radius, int divisions) {
  Builder b;
  const int n = divisions;
  for (int octant = 0; octant < 8; ++octant) {
    const Vector3d sign((octant & 1) != 0 ? -1.0 : 1.0, (octant & 2) != 0 ? -1.0 : 1.0,
                        (octant & 4) != 0 ? -1.0 : 1.0);
    const bool mirrored = sign.prod() < 0.0;
    const auto at = [&](int i, int j) {
      // Integers times a sign: both octants at an edge compute the same position.
      const Vector3d p = sign.cwiseProduct(Vector3d(i, j, n - i - j));
      return b.vertex(centre + radius * p / p.norm());
    };
    const auto face = [&](int p, int q, int r) { mirrored ? b.face(p, r, q) : b.face(p, q, r); };
    for (int i = 0; i < n; ++i) {
      for (int j = 0; i + j < n; ++j) {
        face(at(i, j), at(i + 1, j), at(i, j + 1));
        if (i + j + 1 < n) { face(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)); }
      }
    }
  }
  return b.take();
}

TriangleSurface ring_surface(double radius, double thickness, double angle, int steps, int around) {
  Builder b;
  const bool whole = angle >= 2.0 * std::numbers::pi - 1e-9;
  const int rings = whole ? steps : steps + 1;
  for (int s = 0; s < rings; ++s) {
    const double along = angle * s / steps;
    for (int k = 0; k < around; ++k) {
      const double turn = 2.0 * std::numbers::pi * k / around;
      const double out = radius + thickness * std::cos(turn);
      b.vertex({out * std::cos(along), out * std::sin(along), thickness * std::sin(turn)});
    }
  }
  const auto at = [&](int s, int k) { return (s % rings) * around + k % around; };
  for (int s = 0; s < steps; ++s) {
    for (int k = 0; k < around; ++k) {
      b.quad(at(s, k), at(s + 1, k), at(s + 1, k + 1), at(s, k + 1));
    }
  }
  if (whole) { return b.take(); }
  const int first = b.vertex({radius, 0.0, 0.0});
  const int last = b.vertex({radius * std::cos(angle), radius * std::sin(angle), 0.0});
  for (int k = 0; k < around; ++k) {
    b.face(first, at(0, k), at(0, k + 1));
    b.face(last, at(steps, k + 1), at(steps, k));
  }
  return b.take();
}

TriangleSurface patch_surface(const Eigen::Vector2d& half, int steps,
                              const std::function<double(double, double)>& height) {
  Builder b;
  const int across = steps + 1;
  for (int n = 0; n < across * across; ++n) {
    const double x = half.x() * (2.0 * (n % across) / steps - 1.0);
    const double y = half.y() * (2.0 * (n / across) / steps - 1.0);
    b.vertex({x, y, height(x, y)});
  }
  for (int j = 0; j < steps; ++j) {
    for (int i = 0; i < steps; ++i) {
      const int low = j * across + i;
      b.quad(low, low + across, low + across + 1, low + 1);
    }
  }
  return b.take();
}

}  // namespace palpate
