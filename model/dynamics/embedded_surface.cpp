// SPDX-License-Identifier: MIT
#include "model/dynamics/embedded_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace palpate {

namespace {

using Eigen::Vector3d;
using Place = std::array<int, 3>;

bool is_cell(const NodeGrid& grid, const Place& lowest) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (lowest[axis] < 0 || lowest[axis] + 1 >= grid.count[axis]) { return false; }
  }
  for (int corner = 0; corner < 8; ++corner) {
    if (grid.at(lowest[0] + (corner & 1), lowest[1] + ((corner >> 1) & 1), lowest[2] + (corner >> 2)) < 0) {
      return false;
    }
  }
  return true;
}

/// The place in a cell nearest to `at`, which is counted in spacings from the first node; 0 to 1 along each axis.
Vector3d nearest_in(const Place& cell, const Vector3d& at) {
  return (at - Vector3d(cell[0], cell[1], cell[2])).cwiseMax(0.0).cwiseMin(1.0);
}

/// Of the six tetrahedra around a cell's diagonal the one that holds the place: from the lowest corner along the
/// axis of the largest share, then the next, then the last.
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
  const bool far = !(at.minCoeff() >= -reach - 1.0) || !((at - Vector3d(grid.count[0], grid.count[1], grid.count[2]))
                                                             .maxCoeff() <= reach + 1.0);
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
  for (int l = own[2] - reach; l <= own[2] + reach; ++l) {
    for (int j = own[1] - reach; j <= own[1] + reach; ++j) {
      for (int i = own[0] - reach; i <= own[0] + reach; ++i) {
        const Place cell{i, j, l};
        const double away = (at - Vector3d(i, j, l) - nearest_in(cell, at)).squaredNorm();
        if (away > nearest || (any && away == nearest) || !is_cell(grid, cell)) { continue; }
        nearest = away;
        found = cell;
        any = true;
      }
    }
  }
  return any ? in_cell(grid, found, nearest_in(found, at)) : EmbeddedPoint{};
}

}  // namespace

std::vector<EmbeddedPoint> embed(const NodeVectors& points, const NodeGrid& grid, int reach) {
  std::vector<EmbeddedPoint> embedded;
  for (const auto& point : points.colwise()) { embedded.push_back(embed(Vector3d(point), grid, reach)); }
  return embedded;
}

NodeVectors carried(const NodeVectors& points, const std::vector<EmbeddedPoint>& embedded, const NodeVectors& rest,
                    const NodeVectors& position) {
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
