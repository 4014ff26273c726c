// SPDX-License-Identifier: MIT
#include "reference/track_intervals.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "reference/solution.hpp"

namespace palpate::reference {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

TrackInterval made_of(const Scene& scene, const std::string& material, const std::string& label) {
  const auto found = std::ranges::find(scene.materials, material, &Material::name);
  if (found == scene.materials.end()) { throw SolverError("insertion: no material " + material); }
  const TissueRole role = role_of(*found);
  return {.cutting_force = role == TissueRole::bone ? infinity : found->cutting_force,
          .friction = found->friction,
          .role = role,
          .label = label.empty() ? material : label};
}

std::vector<TrackInterval> base_intervals(const Scene& scene, double entry, double n_z) {
  const Tissue& tissue = scene.tissue;
  std::vector<TrackInterval> parts;
  double begin = entry;
  const bool only_material =
      tissue.source == Source::lattice && tissue.lattice.weights == LatticeWeights::cell;
  if (!only_material) {
    for (const Layer& layer : tissue.layers) {
      parts.push_back(made_of(scene, layer.material, layer.tissue));
      parts.back().begin = begin;
      begin += layer.thickness / n_z;
      parts.back().end = begin;
    }
  }
  if (parts.empty()) {
    parts.push_back(only_material ? made_of(scene, tissue.lattice.material, "") : TrackInterval{});
    parts.back().begin = entry;
  }
  parts.back().end = infinity;
  return parts;
}

struct Stretch {
  double begin = -infinity;
  double end = infinity;
};

/// Where the line point + xi n lies in the body, if it does.
std::optional<Stretch> inside(const Inclusion& body, const Eigen::Vector3d& point,
                              const Eigen::Vector3d& n) {
  const Eigen::Vector3d from = point - body.centre;
  if (body.shape == Inclusion::Shape::sphere) {
    const double middle = -from.dot(n);
    const double radius = 0.5 * body.size.x();
    const double half = radius * radius - (from + middle * n).squaredNorm();
    if (half <= 0.0) { return std::nullopt; }
    return Stretch{middle - std::sqrt(half), middle + std::sqrt(half)};
  }
  Stretch stretch;
  for (int axis = 0; axis < 3; ++axis) {
    const double half = 0.5 * body.size(axis);
    if (n(axis) == 0.0) {
      if (std::abs(from(axis)) > half) { return std::nullopt; }
      continue;
    }
    const double one = (-half - from(axis)) / n(axis);
    const double other = (half - from(axis)) / n(axis);
    stretch.begin = std::max(stretch.begin, std::min(one, other));
    stretch.end = std::min(stretch.end, std::max(one, other));
  }
  if (stretch.end <= stretch.begin) { return std::nullopt; }
  return stretch;
}

/// `body` takes the place of whatever lay in its stretch.
std::vector<TrackInterval> overlaid(const std::vector<TrackInterval>& parts,
                                    const TrackInterval& body) {
  std::vector<TrackInterval> result;
  for (const TrackInterval& part : parts) {
    TrackInterval before = part;
    before.end = std::min(part.end, body.begin);
    TrackInterval after = part;
    after.begin = std::max(part.begin, body.end);
    if (before.begin < before.end) { result.push_back(before); }
    if (body.begin >= part.begin && body.begin < part.end) { result.push_back(body); }
    if (after.begin < after.end) { result.push_back(after); }
  }
  return result;
}

}  // namespace

std::vector<TrackInterval> track_intervals(const Scene& scene, double entry) {
  const Needle& needle = scene.needle.value();
  const Eigen::Vector3d n = needle.direction.normalized();
  const Eigen::Vector3d point{needle.entry.x(), needle.entry.y(), 0.0};
  std::vector<TrackInterval> parts = base_intervals(scene, entry, n.z());
  for (const Inclusion& inclusion : scene.tissue.inclusions) {
    const auto stretch = inside(inclusion, point, n);
    if (!stretch || stretch->end <= entry) { continue; }
    TrackInterval body = made_of(scene, inclusion.material, "");
    body.begin = std::max(stretch->begin, entry);
    body.end = stretch->end;
    parts = overlaid(parts, body);
  }
  return parts;
}

}  // namespace palpate::reference
