// SPDX-License-Identifier: MIT
#include "model/dynamics/node_grid.hpp"

#include <algorithm>
#include <cmath>

namespace palpate {

namespace {

using Eigen::Vector3d;

constexpr double slack = 1e-9;  // of a place, in units of a spacing

/// Neighbouring weights of a place along one axis; count 0 when it lies outside.
struct Between {
  std::array<int, 2> at{0, 0};
  std::array<double, 2> weight{0.0, 0.0};
  int count = 0;
};

Between between(double place, double first, double spacing, int nodes) {
  const double steps = (place - first) / spacing;
  if (steps < -slack || steps > nodes - 1 + slack) { return {}; }
  const int low = std::clamp(static_cast<int>(std::floor(steps)), 0, std::max(nodes - 2, 0));
  const double share = std::clamp(steps - low, 0.0, 1.0);
  return {{low, std::min(low + 1, nodes - 1)}, {1.0 - share, share}, 2};
}

}  // namespace

void number_nodes(NodeGrid& grid) {
  int count = 0;
  for (int& node : grid.node) {
    if (node >= 0) { node = count++; }
  }
}

std::optional<double> skin_depth(const NodeGrid& grid, const Eigen::Vector2d& at) {
  for (const PlaneCrossing& crossing : plane_crossings(grid, {at.x(), at.y(), 0.0}, Vector3d::UnitZ())) {
    return crossing.depth;
  }
  return {};
}

std::vector<int> skin_nodes(const NodeGrid& grid) {
  std::vector<int> skin;
  for (int j = 0; j < grid.count[1]; ++j) {
    for (int i = 0; i < grid.count[0]; ++i) {
      int l = 0;
      while (l < grid.count[2] && grid.at(i, j, l) < 0) { ++l; }
      if (l < grid.count[2]) { skin.push_back(grid.at(i, j, l)); }
    }
  }
  std::ranges::sort(skin);
  return skin;
}

std::vector<PlaneCrossing> plane_crossings(const NodeGrid& grid, const Vector3d& origin, const Vector3d& direction) {
  std::vector<PlaneCrossing> crossings;
  for (int l = 0; l < grid.count[2]; ++l) {
    PlaneCrossing crossing{.depth = (grid.first.z() + l * grid.spacing.z() - origin.z()) / direction.z()};
    const Vector3d at = origin + crossing.depth * direction;
    const Between x = between(at.x(), grid.first.x(), grid.spacing.x(), grid.count[0]);
    const Between y = between(at.y(), grid.first.y(), grid.spacing.y(), grid.count[1]);
    double total = 0.0;
    for (int n = 0; n < x.count * y.count; ++n) {
      const auto i = static_cast<std::size_t>(n % 2);
      const auto j = static_cast<std::size_t>(n / 2);
      const double weight = x.weight[i] * y.weight[j];
      const int node = grid.at(x.at[i], y.at[j], l);
      if (node < 0 || weight <= 1e-12) { continue; }
      crossing.supports.push_back({node, weight});
      total += weight;
    }
    if (crossing.supports.empty()) { continue; }
    for (NeedlePath::Support& support : crossing.supports) { support.weight /= total; }
    crossings.push_back(std::move(crossing));
  }
  return crossings;
}

}  // namespace palpate
