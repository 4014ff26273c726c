// SPDX-License-Identifier: MIT
#include "model/dynamics/voxel_tissue.hpp"

#include <algorithm>
#include <cmath>

namespace palpate {

namespace {

using Eigen::Vector3d;

constexpr double slack = 1e-9;  // of a place, in units of a box

std::uint16_t material_at(const VoxelTissue& tissue, const Vector3d& point) {
  const Vector3d cell = (point - tissue.boxes.low).cwiseQuotient(tissue.boxes.size);
  const auto i = static_cast<int>(std::floor(cell.x()));
  const auto j = static_cast<int>(std::floor(cell.y()));
  const auto l = static_cast<int>(std::floor(cell.z()));
  return tissue.boxes.holds(i, j, l) ? tissue.material[tissue.boxes.index(i, j, l)] : std::uint16_t{0};
}

/// Depths at which the line leaves one box for the next, sorted, from `first` to the far side of the grid.
std::vector<double> wall_depths(const BoxGrid& grid, const Vector3d& origin, const Vector3d& n, double first) {
  std::vector<double> depths{first};
  const Vector3d high = grid.low + grid.size.cwiseProduct(Vector3d(grid.count[0], grid.count[1], grid.count[2]));
  const double last = (high.z() - origin.z()) / n.z();
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(n(axis)) < 1e-12) { continue; }
    for (int wall = 0; wall <= grid.count[static_cast<std::size_t>(axis)]; ++wall) {
      const double depth = (grid.low(axis) + wall * grid.size(axis) - origin(axis)) / n(axis);
      if (depth > first && depth <= last) { depths.push_back(depth); }
    }
  }
  std::ranges::sort(depths);
  return depths;
}

/// Lines that run along a wall of boxes see the box beside it of greater coordinates.
Vector3d off_the_walls(const BoxGrid& grid, const Vector3d& origin) {
  return origin + slack * grid.size.cwiseProduct(Vector3d(1.0, 1.0, 0.0));
}

struct Run {
  double begin = 0.0;
  double end = 0.0;
  std::uint16_t material = 0;
};

PathInterval interval_of(const VoxelTissue& tissue, const std::vector<Material>& materials, const Run& run) {
  PathInterval interval{.begin = run.begin, .end = run.end, .label = "gap"};
  if (run.material == 0) { return interval; }
  const std::string& name = tissue.materials[run.material - 1U];
  const auto found = std::ranges::find(materials, name, &Material::name);
  return found == materials.end() ? interval : interval_in(*found, name, run.begin, run.end);
}

/// Where the skin is steep, nodes beside the line carry it before its own box is tissue.
void join_first_gap(const BoxGrid& grid, std::vector<PathInterval>& intervals) {
  if (intervals.size() < 2 || intervals[0].label != "gap" || intervals[1].role == TissueRole::bone) { return; }
  if (intervals[0].end - intervals[0].begin > 2.0 * grid.size.z()) { return; }
  intervals[1].begin = intervals[0].begin;
  intervals.erase(intervals.begin());
}

}  // namespace

std::vector<PathInterval> voxel_intervals(const VoxelTissue& tissue, const std::vector<Material>& materials,
                                          const Vector3d& origin, const Vector3d& direction, double first) {
  const Vector3d from = off_the_walls(tissue.boxes, origin);
  const std::vector<double> depths = wall_depths(tissue.boxes, from, direction, first);
  std::vector<Run> runs;
  for (std::size_t n = 0; n + 1 < depths.size(); ++n) {
    const double middle = 0.5 * (depths[n] + depths[n + 1]);
    const std::uint16_t material = material_at(tissue, from + middle * direction);
    const bool same = !runs.empty() && runs.back().material == material;
    if (same) {
      runs.back().end = depths[n + 1];
    } else {
      runs.push_back({depths[n], depths[n + 1], material});
    }
  }
  std::vector<PathInterval> intervals;
  for (const Run& run : runs) {
    PathInterval next = interval_of(tissue, materials, run);
    const bool thin = run.end - run.begin < tissue.thinnest && next.role != TissueRole::bone;
    const bool joined = !intervals.empty() && (thin || intervals.back().label == next.label);
    if (joined) {
      intervals.back().end = run.end;
    } else {
      intervals.push_back(std::move(next));
    }
  }
  join_first_gap(tissue.boxes, intervals);
  if (intervals.empty()) { intervals.push_back({.begin = first, .label = "gap"}); }
  intervals.back().end = std::numeric_limits<double>::infinity();
  return intervals;
}

}  // namespace palpate
