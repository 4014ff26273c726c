// SPDX-License-Identifier: MIT

#include "model/tissue/skin.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <boost/pending/disjoint_sets.hpp>
#include <cmath>
#include <limits>
#include <numeric>
#include <unsupported/Eigen/BVH>
#include <vector>

#include "model/problem/rules.hpp"

namespace palpate {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Box = Eigen::AlignedBox3d;
using Tree = Eigen::KdBVH<double, 3, int>;
using Corners = std::array<Vector3d, 3>;

constexpr double same_place = 1e-9;  // [m]
constexpr double farthest = 10.0;    // largest distance of a body from the origin [m]
constexpr double share_rounding =
    1e-12;  // tolerance on barycentric coordinates, so that neighbouring faces leave no gap

Corners corners_of(const TriangleSurface& surface, int face) {
  return {surface.corner(face, 0), surface.corner(face, 1), surface.corner(face, 2)};
}

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Returns z of a face at (x, y). Empty outside the face, and for faces parallel to z, whose edges
/// belong to other faces.
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
  bool above = square > 0.0;  // the foot of the perpendicular is inside the face
  double nearest = std::numeric_limits<double>::infinity();
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

/// Intersection of a face with a line along z.
struct Meeting {
  double z;
  bool open;  ///< the face belongs to a sheet, not to a closed surface
};

struct AlongZ {
  const TriangleSurface& surface;
  const std::vector<char>& open;  ///< per face
  Vector2d at;
  std::vector<Meeting> meets{};

  bool intersectVolume(const Box& box) const {
    return at.x() >= box.min().x() && at.x() <= box.max().x() && at.y() >= box.min().y() &&
           at.y() <= box.max().y();
  }
  bool intersectObject(int face) {
    if (const auto z = height(corners_of(surface, face), at)) {
      meets.push_back({*z, open[static_cast<std::size_t>(face)] != 0});
    }
    return false;  // continue the search
  }
};

struct Nearest {
  using Scalar = double;
  const TriangleSurface& surface;
  Vector3d point;

  double minimumOnVolume(const Box& box) const { return box.squaredExteriorDistance(point); }
  double minimumOnObject(int face) const {
    return squared_distance(point, corners_of(surface, face));
  }
};

/// Returns for each face whether its part of the surface, connected by vertices, has an edge of one
/// face alone.
std::vector<char> open_faces(const TriangleSurface& surface) {
  const auto vertices = static_cast<std::size_t>(surface.vertex.cols());
  boost::disjoint_sets_with_storage<> parts(vertices);
  const auto part_of = [&parts](int vertex) {
    return parts.find_set(static_cast<std::size_t>(vertex));
  };
  std::vector<std::array<int, 2>> edges;
  edges.reserve(3 * surface.triangle.size());
  for (const std::array<int, 3>& face : surface.triangle) {
    for (std::size_t n = 0; n < 3; ++n) {
      const int a = face[n];
      const int b = face[(n + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b)});
      parts.union_set(static_cast<std::size_t>(a), static_cast<std::size_t>(b));
    }
  }
  std::ranges::sort(edges);
  std::vector<char> open_part(vertices, 0);
  for (std::size_t begin = 0; begin < edges.size();) {
    std::size_t end = begin + 1;
    while (end < edges.size() && edges[end] == edges[begin]) { ++end; }
    if (end - begin == 1) { open_part[part_of(edges[begin][0])] = 1; }
    begin = end;
  }
  std::vector<char> open;
  open.reserve(surface.triangle.size());
  for (const std::array<int, 3>& face : surface.triangle) {
    open.push_back(open_part[part_of(face[0])]);
  }
  return open;
}

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
  std::vector<char> open;  ///< per face: it belongs to a sheet
  Tree tree;
};

Skin::Skin(TriangleSurface surface, bool shapes_layers) {
  Tree tree = tree_of(surface);
  std::vector<char> open = open_faces(surface);
  parts_ = std::make_unique<const Parts>(
      Parts{std::move(surface), shapes_layers, std::move(open), std::move(tree)});
}
Skin::~Skin() = default;

const TriangleSurface& Skin::surface() const { return parts_->surface; }
bool Skin::shapes_layers() const { return parts_->shapes_layers; }

std::optional<Skin::Stretch> Skin::beneath(double x, double y) const {
  AlongZ line{.surface = parts_->surface, .open = parts_->open, .at = {x, y}};
  Eigen::BVIntersect(parts_->tree, line);
  if (line.meets.empty()) { return {}; }
  std::ranges::sort(line.meets, {}, &Meeting::z);
  Stretch stretch{.top = line.meets.front().z};
  // Neighbouring faces that share the intersected edge or corner count once.
  const auto again = std::ranges::find_if(
      line.meets, [&](const Meeting& meeting) { return meeting.z > stretch.top + same_place; });
  if (again == line.meets.end()) { return stretch; }
  stretch.bottom = again->z;
  stretch.between_sheets =
      std::ranges::any_of(line.meets.begin(), std::next(again), &Meeting::open);
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
    return "with scale and origin it reaches to " + number_in_words(reach) +
           " m; must lie within " + number_in_words(farthest) + " m";
  }
  return {};
}

namespace {

using Place = std::array<int, 3>;

bool is_cell(const NodeGrid& grid, const Place& lowest) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (lowest[axis] < 0 || lowest[axis] + 1 >= grid.count[axis]) { return false; }
  }
  bool all = true;
  for_each_corner(lowest[0], lowest[1], lowest[2],
                  [&](int i, int j, int l) { all = all && grid.at(i, j, l) >= 0; });
  return all;
}

/// Returns the position in a cell nearest to `at`, with 0 to 1 along each axis. `at` is in spacings
/// from the first node.
Vector3d nearest_in(const Place& cell, const Vector3d& at) {
  return (at - Vector3d(cell[0], cell[1], cell[2])).cwiseMax(0.0).cwiseMin(1.0);
}

/// Returns the embedding in one of the six tetrahedra around a cell's diagonal: from the lowest
/// corner along the axis of the largest coordinate, then the next, then the last.
EmbeddedPoint in_cell(const NodeGrid& grid, const Place& cell, const Vector3d& share) {
  std::array<int, 3> axis{0, 1, 2};
  std::ranges::stable_sort(axis, std::ranges::greater{}, [&](int n) { return share(n); });
  EmbeddedPoint point;
  Place corner = cell;
  double before = 1.0;
  for (std::size_t n = 0; n < 4; ++n) {
    const double next = n < 3 ? share(axis[n]) : 0.0;
    point.node[n] = grid.at(corner[0], corner[1], corner[2]);
    point.weight[n] = before - next;
    before = next;
    if (n < 3) { ++corner[static_cast<std::size_t>(axis[n])]; }
  }
  return point;
}

EmbeddedPoint embed(const Vector3d& point, const NodeGrid& grid, int reach) {
  const Vector3d at = (point - grid.first).cwiseQuotient(grid.spacing);
  const bool far =
      !(at.minCoeff() >= -reach - 1.0) ||
      !((at - Vector3d(grid.count[0], grid.count[1], grid.count[2])).maxCoeff() <= reach + 1.0);
  if (far) { return {}; }
  Place own{};
  for (std::size_t n = 0; n < 3; ++n) {  // the last plane of nodes belongs to the cell before it
    const int floor = static_cast<int>(std::floor(at(static_cast<int>(n))));
    own[n] = at(static_cast<int>(n)) == grid.count[n] - 1 ? floor - 1 : floor;
  }
  if (is_cell(grid, own)) { return in_cell(grid, own, nearest_in(own, at)); }
  double nearest = reach * reach;
  Place found = own;
  bool any = false;
  const auto offset = [&](int by) { return Place{own[0] + by, own[1] + by, own[2] + by}; };
  for_each_between(offset(-reach), offset(reach), [&](int i, int j, int l) {
    const Place cell{i, j, l};
    const double away = (at - Vector3d(i, j, l) - nearest_in(cell, at)).squaredNorm();
    if (away > nearest || (any && away == nearest) || !is_cell(grid, cell)) { return; }
    nearest = away;
    found = cell;
    any = true;
  });
  return any ? in_cell(grid, found, nearest_in(found, at)) : EmbeddedPoint{};
}

}  // namespace

std::vector<EmbeddedPoint> embed(const NodeVectors& points, const NodeGrid& grid, int reach) {
  std::vector<EmbeddedPoint> embedded;
  for (const auto& point : points.colwise()) {
    embedded.push_back(embed(Vector3d(point), grid, reach));
  }
  return embedded;
}

NodeVectors carried(const NodeVectors& points, const std::vector<EmbeddedPoint>& embedded,
                    const NodeVectors& rest, const NodeVectors& position) {
  NodeVectors places = points;
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    const EmbeddedPoint& point = embedded[static_cast<std::size_t>(p)];
    for (std::size_t n = 0; point.follows() && n < 4; ++n) {
      places.col(p) += point.weight[n] * (position.col(point.node[n]) - rest.col(point.node[n]));
    }
  }
  return places;
}

}  // namespace palpate
