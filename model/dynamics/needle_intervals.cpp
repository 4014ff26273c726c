// SPDX-License-Identifier: MIT
/// The materials along a needle's line.
#include <algorithm>
#include <cmath>

#include "model/dynamics/needle_path.hpp"
#include "model/dynamics/tissue_grid.hpp"
#include "model/dynamics/tissue_map.hpp"
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

PathInterval interval_of(const Scene& scene, const Layer& layer) {
  return interval_of(find_material(scene, layer.material), layer.tissue.empty() ? layer.material : layer.tissue);
}

/// Layers beneath a skin that need not be flat, and gaps where the line leaves the body. Nodes begin within half a
/// spacing of the skin; layers are counted from them, so that the first is as thick as it is.
class LayersOnLine {
 public:
  LayersOnLine(const Scene& scene, const Eigen::Vector3d& origin, const Eigen::Vector3d& n)
      : scene_(scene), origin_(origin), n_(n), step_(0.1 * scene.tissue.block.spacing) {}

  std::vector<PathInterval> from(double first) {
    const double start = skin_near(first);
    const double shift = first - start;
    const LatticeShape block = block_shape(scene_);
    const double last = (block.spacing * (block.nodes[2] - 1) - origin_.z()) / n_.z();
    std::vector<PathInterval> intervals;
    std::ptrdiff_t here = std::max<std::ptrdiff_t>(layer(start), 0);
    add(intervals, here, first);
    for (int n = 0; start + n * step_ < last; ++n) {
      double begin = start + n * step_;
      const double end = start + (n + 1) * step_;
      while (layer(end) != here) {
        begin = change(begin, end, here);
        here = layer(begin);
        add(intervals, here, begin + shift);
      }
    }
    return intervals;
  }

 private:
  static constexpr std::ptrdiff_t outside = -1;
  static constexpr double same_place = 1e-9;  // [m]

  [[nodiscard]] std::ptrdiff_t layer(double xi) const {
    const double depth = depth_in_layers(scene_, origin_ + xi * n_);
    return depth < -same_place ? outside : static_cast<std::ptrdiff_t>(layer_at(scene_.tissue.layers, depth));
  }
  /// Where the line enters the body, within one and a half spacings of `first`; `first` where it does not.
  [[nodiscard]] double skin_near(double first) const {
    for (int n = -15; n < 15; ++n) {
      const double end = first + (n + 1) * step_;
      if (layer(first + n * step_) == outside && layer(end) != outside) {
        return change(first + n * step_, end, outside);
      }
    }
    return first;
  }
  /// The first place past a change between two places.
  [[nodiscard]] double change(double low, double high, std::ptrdiff_t before) const {
    while (high - low > same_place) {
      const double middle = 0.5 * (low + high);
      (layer(middle) == before ? low : high) = middle;
    }
    return high;
  }
  void add(std::vector<PathInterval>& intervals, std::ptrdiff_t of, double begin) const {
    if (!intervals.empty()) { intervals.back().end = begin; }
    intervals.push_back(of == outside ? PathInterval{.label = "gap"}
                                      : interval_of(scene_, scene_.tissue.layers[static_cast<std::size_t>(of)]));
    intervals.back().begin = begin;
    intervals.back().end = infinity;
  }

  const Scene& scene_;
  Eigen::Vector3d origin_;
  Eigen::Vector3d n_;
  double step_;
};

/// Layers, or the one material of a lattice, from `first` on.
std::vector<PathInterval> ground(const Scene& scene, const Eigen::Vector3d& origin, const Eigen::Vector3d& n,
                                 double first) {
  if (layers_follow_skin(scene)) { return LayersOnLine(scene, origin, n).from(first); }
  std::vector<PathInterval> intervals;
  double begin = first;
  for (const Layer& layer : scene.tissue.layers) {
    PathInterval next = interval_of(scene, layer);
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
  std::vector<PathInterval> line = ground(scene, origin, direction, first);
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

std::string label_at(const Scene& scene, const Eigen::Vector3d& point, double first) {
  if (layers_follow_skin(scene)) {
    const std::vector<Layer>& layers = scene.tissue.layers;
    const std::vector<Inclusion>& bodies = scene.tissue.inclusions;
    const auto body = std::find_if(bodies.rbegin(), bodies.rend(),
                                   [&](const Inclusion& each) { return contains(each, point); });
    if (body != bodies.rend()) { return body->material; }
    return interval_of(scene, layers[layer_at(layers, depth_in_layers(scene, point))]).label;
  }
  const auto line = intervals_along(scene, {point.x(), point.y(), 0.0}, Eigen::Vector3d::UnitZ(), first);
  const auto found = std::ranges::find_if(line, [&](const PathInterval& each) { return point.z() < each.end; });
  return found == line.end() ? line.back().label : found->label;
}

}  // namespace palpate
