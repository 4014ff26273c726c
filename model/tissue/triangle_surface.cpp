// SPDX-License-Identifier: MIT

#include "model/tissue/triangle_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "model/problem/rules.hpp"

namespace palpate {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

std::string place_in_words(const Vector3d& at) {
  return "(" + number_in_words(at.x()) + ", " + number_in_words(at.y()) + ", " +
         number_in_words(at.z()) + ") m";
}

struct Edge {
  int low = 0;
  int high = 0;
  int face = 0;
  bool ascending = true;  ///< the face traverses the edge from low to high
};

std::vector<Edge> sorted_edges(const TriangleSurface& surface) {
  std::vector<Edge> edges;
  edges.reserve(3 * surface.triangle.size());
  for (std::size_t f = 0; f < surface.triangle.size(); ++f) {
    for (std::size_t n = 0; n < 3; ++n) {
      const int a = surface.triangle[f][n];
      const int b = surface.triangle[f][(n + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), static_cast<int>(f), a < b});
    }
  }
  std::ranges::sort(edges, {}, [](const Edge& e) { return std::array{e.low, e.high, e.face}; });
  return edges;
}

std::string edge_in_words(const TriangleSurface& surface, const Edge& edge) {
  return "edge " + place_in_words(surface.vertex.col(edge.low)) + " to " +
         place_in_words(surface.vertex.col(edge.high));
}

/// Checks that every edge is traversed equally often in both directions.
std::optional<std::string> edge_defect(const TriangleSurface& surface) {
  const std::vector<Edge> edges = sorted_edges(surface);
  for (std::size_t begin = 0; begin < edges.size();) {
    std::size_t end = begin;
    int balance = 0;
    for (; end < edges.size() && edges[end].low == edges[begin].low &&
           edges[end].high == edges[begin].high;
         ++end) {
      balance += edges[end].ascending ? 1 : -1;
    }
    const Edge& edge = edges[begin];
    if (balance != 0 && (end - begin) % 2 == 1) {
      return "open: " + edge_in_words(surface, edge) + " of face " + std::to_string(edge.face) +
             " has no face on its other side; a closed surface is needed";
    }
    if (balance != 0) {
      return "faces " + std::to_string(edge.face) + " and " +
             std::to_string(edges[begin + 1].face) + " are turned against each other at " +
             edge_in_words(surface, edge) +
             "; all faces must be counter-clockwise as seen from outside";
    }
    begin = end;
  }
  return {};
}

std::optional<std::string> vertex_defect(const TriangleSurface& surface) {
  const auto count = static_cast<int>(surface.vertex.cols());
  for (int i = 0; i < count; ++i) {
    if (!surface.vertex.col(i).allFinite()) {
      return "vertex " + std::to_string(i) +
             " has a coordinate that is not finite; all must be finite";
    }
  }
  for (std::size_t f = 0; f < surface.triangle.size(); ++f) {
    for (const int i : surface.triangle[f]) {
      if (i < 0 || i >= count) {
        return "face " + std::to_string(f) + " names vertex " + std::to_string(i) + "; 0 to " +
               std::to_string(count - 1);
      }
    }
  }
  if (surface.triangle.empty()) { return "no faces; a closed surface is needed"; }
  return {};
}

}  // namespace

SolidMoments moments_of(const TriangleSurface& surface) {
  SolidMoments solid;
  if (surface.triangle.empty()) { return solid; }
  const Vector3d apex = surface.corner(0, 0);
  Vector3d first = Vector3d::Zero();
  Matrix3d second = Matrix3d::Zero();  // integral of x x^T about the apex
  for (int f = 0; f < static_cast<int>(surface.triangle.size()); ++f) {
    const Vector3d a = surface.corner(f, 0) - apex;
    const Vector3d b = surface.corner(f, 1) - apex;
    const Vector3d c = surface.corner(f, 2) - apex;
    const double volume = a.dot(b.cross(c)) / 6.0;
    const Vector3d sum = a + b + c;
    solid.volume += volume;
    first += volume / 4.0 * sum;
    second += volume / 20.0 *
              (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  if (solid.volume == 0.0) { return solid; }
  const Vector3d mean = first / solid.volume;
  second -= solid.volume * mean * mean.transpose();
  solid.centroid = apex + mean;
  solid.inertia = second.trace() * Matrix3d::Identity() - second;
  return solid;
}

void weld(TriangleSurface& surface) {
  const auto count = static_cast<std::size_t>(surface.vertex.cols());
  std::vector<int> order(count);
  std::iota(order.begin(), order.end(), 0);
  const auto place = [&](int i) {
    return std::array{surface.vertex(0, i), surface.vertex(1, i), surface.vertex(2, i)};
  };
  std::ranges::stable_sort(order, [&](int a, int b) { return place(a) < place(b); });
  std::vector<int> first(count);
  for (std::size_t n = 0; n < count; ++n) {
    const bool same = n > 0 && place(order[n]) == place(order[n - 1]);
    first[static_cast<std::size_t>(order[n])] =
        same ? first[static_cast<std::size_t>(order[n - 1])] : order[n];
  }
  for (std::array<int, 3>& face : surface.triangle) {
    for (int& i : face) {
      if (i >= 0 && i < static_cast<int>(count)) { i = first[static_cast<std::size_t>(i)]; }
    }
  }
  std::erase_if(surface.triangle, [](const std::array<int, 3>& t) {
    return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
  });
}

namespace {

/// Six times the signed volume of a tetrahedron. The sign is valid only if the value exceeds its
/// rounding error.
struct Side {
  double value = 0.0;
  double doubt = 0.0;

  [[nodiscard]] int sign() const { return value > doubt ? 1 : value < -doubt ? -1 : 0; }
};

Side side_of(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  const Vector3d ab = b - a;
  const Vector3d ac = c - a;
  const Vector3d ad = d - a;
  constexpr double doubt = 1e-9;  // for coordinates in single precision, which most files have
  return {ad.dot(ab.cross(ac)), doubt * ab.norm() * ac.norm() * std::max(ad.norm(), ab.norm())};
}

/// Returns true if the segment from p to q crosses a face through its interior or its edges.
bool pierces(const Vector3d& p, const Vector3d& q, const std::array<Vector3d, 3>& t) {
  const int from = side_of(t[0], t[1], t[2], p).sign();
  const int to = side_of(t[0], t[1], t[2], q).sign();
  if (from * to >= 0) { return false; }
  const std::array<int, 3> round{side_of(p, q, t[0], t[1]).sign(), side_of(p, q, t[1], t[2]).sign(),
                                 side_of(p, q, t[2], t[0]).sign()};
  const auto [least, most] = std::ranges::minmax(round);
  return least * most >= 0 && (least != 0 || most != 0);
}

/// Search for two faces without a common edge that intersect by more than rounding error. Faces are
/// sorted by their smallest x, and each is compared with the faces that overlap it along x.
class Sweep {
 public:
  explicit Sweep(const TriangleSurface& surface)
      : surface_(surface), extents_(surface.triangle.size()) {
    for (std::size_t f = 0; f < extents_.size(); ++f) {
      const auto t = corners(static_cast<int>(f));
      for (const Vector3d& corner : t) { extents_[f].extend(corner); }
    }
  }

  std::optional<std::array<int, 2>> run() {
    std::vector<int> order(extents_.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, [&](int f) { return of(f).min().x(); });
    std::vector<int> active;
    for (const int f : order) {
      std::erase_if(active, [&](int g) { return of(g).max().x() < of(f).min().x(); });
      for (const int g : active) {
        if (of(f).intersects(of(g)) && cross(f, g)) {
          return std::array{std::min(f, g), std::max(f, g)};
        }
      }
      active.push_back(f);
    }
    return {};
  }

 private:
  [[nodiscard]] const Eigen::AlignedBox3d& of(int face) const {
    return extents_[static_cast<std::size_t>(face)];
  }
  [[nodiscard]] std::array<Vector3d, 3> corners(int face) const {
    return {surface_.corner(face, 0), surface_.corner(face, 1), surface_.corner(face, 2)};
  }
  [[nodiscard]] bool cross(int f, int g) const { return edges_pierce(f, g) || edges_pierce(g, f); }

  /// Returns true if an edge of f that shares no vertex with g crosses g.
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
  std::vector<Eigen::AlignedBox3d> extents_;
};

}  // namespace

std::optional<std::string> surface_defect(const TriangleSurface& surface) {
  if (auto defect = vertex_defect(surface)) { return defect; }
  if (auto defect = edge_defect(surface)) { return defect; }
  if (const auto faces = Sweep(surface).run()) {
    return "faces " + std::to_string((*faces)[0]) + " and " + std::to_string((*faces)[1]) +
           " cross each other near " + place_in_words(surface.corner((*faces)[0], 0)) +
           "; a surface must not intersect itself";
  }
  const double volume = moments_of(surface).volume;
  if (volume <= 0.0) {
    return "inside out: its volume is " + number_in_words(volume) + " m^3, face 0 at " +
           place_in_words(surface.corner(0, 0)) +
           " looks inwards; faces must be counter-clockwise as seen from outside";
  }
  return {};
}

}  // namespace palpate
