// SPDX-License-Identifier: MIT
#include "model/dynamics/skin.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include <Eigen/Geometry>
#include <unsupported/Eigen/BVH>

#include "model/dynamics/rules.hpp"

namespace palpate {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Box = Eigen::AlignedBox3d;
using Tree = Eigen::KdBVH<double, 3, int>;
using Corners = std::array<Vector3d, 3>;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double same_place = 1e-9;       // [m]
constexpr double farthest = 10.0;         // from the origin that a body may reach [m]
constexpr double share_rounding = 1e-12;  // of shares of a face: neighbours leave no gap between them

Corners corners_of(const TriangleSurface& surface, int face) {
  return {surface.corner(face, 0), surface.corner(face, 1), surface.corner(face, 2)};
}

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// z of a face at (x, y); nothing beside it, and on faces along z, whose rims others share.
std::optional<double> height(const Corners& t, const Vector2d& at) {
  const Vector2d a = t[0].head<2>();
  const Vector2d u = t[1].head<2>() - a;
  const Vector2d v = t[2].head<2>() - a;
  const double area = cross(u, v);
  if (std::abs(area) <= share_rounding * std::max(u.squaredNorm(), v.squaredNorm())) { return {}; }
  const double b = cross(at - a, v) / area;
  const double c = cross(u, at - a) / area;
  if (std::min({b, c, 1.0 - b - c}) < -share_rounding) { return {}; }
  return t[0].z() + b * (t[1].z() - t[0].z()) + c * (t[2].z() - t[0].z());
}

double squared_distance_to_edge(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const Vector3d way = b - a;
  const double square = way.squaredNorm();
  const double share = square > 0.0 ? std::clamp((p - a).dot(way) / square, 0.0, 1.0) : 0.0;
  return (p - a - share * way).squaredNorm();
}

double squared_distance(const Vector3d& p, const Corners& t) {
  const Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]);
  const double square = normal.squaredNorm();
  bool above = square > 0.0;  // the foot of the perpendicular lies in the face
  double nearest = infinity;
  for (std::size_t n = 0; n < 3; ++n) {
    const Vector3d& a = t[n];
    const Vector3d& b = t[(n + 1) % 3];
    above = above && (b - a).cross(p - a).dot(normal) >= 0.0;
    nearest = std::min(nearest, squared_distance_to_edge(p, a, b));
  }
  if (!above) { return nearest; }
  const double off = (p - t[0]).dot(normal);
  return std::min(nearest, off * off / square);
}

/// z of the faces on a line along z.
struct AlongZ {
  const TriangleSurface& surface;
  Vector2d at;
  std::vector<double> meets{};

  bool intersectVolume(const Box& box) const {
    return at.x() >= box.min().x() && at.x() <= box.max().x() && at.y() >= box.min().y() && at.y() <= box.max().y();
  }
  bool intersectObject(int face) {
    if (const auto z = height(corners_of(surface, face), at)) { meets.push_back(*z); }
    return false;  // the search goes on
  }
};

struct Nearest {
  using Scalar = double;
  const TriangleSurface& surface;
  Vector3d point;

  double minimumOnVolume(const Box& box) const { return box.squaredExteriorDistance(point); }
  double minimumOnObject(int face) const { return squared_distance(point, corners_of(surface, face)); }
};

Tree tree_of(const TriangleSurface& surface) {
  std::vector<int> faces(surface.triangle.size());
  std::iota(faces.begin(), faces.end(), 0);
  std::vector<Box> boxes;
  boxes.reserve(faces.size());
  for (const int face : faces) {
    Box box;
    for (const Vector3d& corner : corners_of(surface, face)) { box.extend(corner); }
    const Vector3d doubt = Vector3d::Constant(share_rounding * box.diagonal().norm());
    boxes.emplace_back(box.min() - doubt, box.max() + doubt);
  }
  return {faces.begin(), faces.end(), boxes.begin(), boxes.end()};
}

}  // namespace

struct Skin::Parts {
  TriangleSurface surface;
  bool shapes_layers = true;
  Tree tree;
};

Skin::Skin(TriangleSurface surface, bool shapes_layers) {
  Tree tree = tree_of(surface);
  parts_ = std::make_unique<const Parts>(Parts{std::move(surface), shapes_layers, std::move(tree)});
}
Skin::~Skin() = default;

const TriangleSurface& Skin::surface() const { return parts_->surface; }
bool Skin::shapes_layers() const { return parts_->shapes_layers; }

std::optional<Skin::Stretch> Skin::beneath(double x, double y) const {
  AlongZ line{.surface = parts_->surface, .at = {x, y}};
  Eigen::BVIntersect(parts_->tree, line);
  if (line.meets.empty()) { return {}; }
  std::ranges::sort(line.meets);
  Stretch stretch{.top = line.meets.front()};
  // Neighbours that share the edge or the corner that is met count once.
  const auto again =
      std::ranges::find_if(line.meets, [&](double z) { return z > stretch.top + same_place; });
  if (again != line.meets.end()) { stretch.bottom = *again; }
  return stretch;
}

double Skin::distance(const Vector3d& point) const {
  Nearest nearest{.surface = parts_->surface, .point = point};
  return std::sqrt(Eigen::BVMinimize(parts_->tree, nearest));
}

double Skin::depth(const Vector3d& point) const {
  const std::optional<Stretch> tissue = beneath(point.x(), point.y());
  const double away = distance(point);
  return tissue && point.z() >= tissue->top && point.z() <= tissue->bottom ? away : -away;
}

std::optional<std::string> skin_defect(const TriangleSurface& surface) {
  if (surface.triangle.empty()) { return "no faces; must have at least one"; }
  for (std::size_t f = 0; f < surface.triangle.size(); ++f) {
    for (const int vertex : surface.triangle[f]) {
      const bool known = vertex >= 0 && vertex < surface.vertex.cols();
      if (!known || !surface.vertex.col(vertex).allFinite()) {
        return "vertex " + std::to_string(vertex) + " of face " + std::to_string(f) +
               (known ? " is not finite; must be three finite numbers" : " does not exist");
      }
    }
  }
  const double reach = surface.vertex.cwiseAbs().maxCoeff();
  if (!(reach <= farthest)) {
    return "with scale and origin it reaches to " + number_in_words(reach) + " m; must lie within " +
           number_in_words(farthest) + " m";
  }
  return {};
}

}  // namespace palpate
