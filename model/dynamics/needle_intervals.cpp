// SPDX-License-Identifier: MIT
/// The materials along a needle's line.
#include <algorithm>
#include <cmath>

#include "model/dynamics/needle_path.hpp"
#include "model/dynamics/voxel_tissue.hpp"

namespace palpate {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

struct Stretch {
  double begin = infinity;
  double end = -infinity;
};

const Material* find_material(const Scene& scene, const std::string& name) {
  const auto found = std::ranges::find(scene.materials, name, &Material::name);
  return found == scene.materials.end() ? nullptr : &*found;
}

/// Where the line origin + xi n is inside a body; begin >= end when nowhere.
Stretch inside(const Inclusion& body, const Eigen::Vector3d& origin, const Eigen::Vector3d& n) {
  const Eigen::Vector3d from = origin - body.centre;
  if (body.shape == Inclusion::Shape::sphere) {
    const double radius = 0.5 * body.size.x();
    const double half = from.dot(n);
    const double square = half * half - from.squaredNorm() + radius * radius;
    if (square <= 0.0) { return {}; }
    return {-half - std::sqrt(square), -half + std::sqrt(square)};
  }
  Stretch stretch{-infinity, infinity};
  for (int axis = 0; axis < 3; ++axis) {
    const double reach = 0.5 * body.size(axis);
    if (n(axis) == 0.0) {
      if (std::abs(from(axis)) > reach) { return {}; }
      continue;
    }
    const double one = (-reach - from(axis)) / n(axis);
    const double other = (reach - from(axis)) / n(axis);
    stretch.begin = std::max(stretch.begin, std::min(one, other));
    stretch.end = std::min(stretch.end, std::max(one, other));
  }
  return stretch;
}

PathInterval interval_of(const Material* material, std::string label) {
  if (material == nullptr) { return {.label = std::move(label)}; }
  return interval_in(*material, std::move(label), 0.0, infinity);
}

/// Layers, or the one material of a lattice, from `first` on.
std::vector<PathInterval> ground(const Scene& scene, const Eigen::Vector3d& n, double first) {
  std::vector<PathInterval> intervals;
  double begin = first;
  for (const Layer& layer : scene.tissue.layers) {
    PathInterval next = interval_of(find_material(scene, layer.material),
                                    layer.tissue.empty() ? layer.material : layer.tissue);
    next.begin = begin;
    next.end = begin += layer.thickness / n.z();
    intervals.push_back(std::move(next));
  }
  if (intervals.empty()) {
    const std::string& name = scene.tissue.lattice.material;
    intervals.push_back(interval_of(find_material(scene, name), name));
    intervals.front().begin = first;
  }
  intervals.back().end = infinity;
  return intervals;
}

}  // namespace

PathInterval interval_in(const Material& material, std::string label, double begin, double end) {
  const TissueRole role = role_of(material);
  return {.begin = begin,
          .end = end,
          .cutting_force = role == TissueRole::bone ? infinity : material.cutting_force,
          .friction = material.friction,
          .role = role,
          .label = std::move(label)};
}

std::vector<PathInterval> intervals_along(const Scene& scene, const Eigen::Vector3d& origin,
                                          const Eigen::Vector3d& direction, double first) {
  if (scene.tissue.voxels) {
    return voxel_intervals(*scene.tissue.voxels, scene.materials, origin, direction, first);
  }
  std::vector<PathInterval> line = ground(scene, direction, first);
  for (const Inclusion& body : scene.tissue.inclusions) {
    Stretch within = inside(body, origin, direction);
    within.begin = std::max(within.begin, first);
    if (!(within.end > within.begin)) { continue; }
    PathInterval middle = interval_of(find_material(scene, body.material), body.material);
    middle.begin = within.begin;
    middle.end = within.end;
    std::vector<PathInterval> cut;
    for (const PathInterval& old : line) {
      if (old.begin < within.begin) {
        cut.push_back(old);
        cut.back().end = std::min(old.end, within.begin);
      }
      if (old.end > within.begin && old.begin <= within.begin) { cut.push_back(middle); }
      if (old.end > within.end) {
        cut.push_back(old);
        cut.back().begin = std::max(old.begin, within.end);
      }
    }
    line = std::move(cut);
  }
  return line;
}

}  // namespace palpate
