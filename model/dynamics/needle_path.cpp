// SPDX-License-Identifier: MIT
#include "model/dynamics/needle_path.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "model/dynamics/network_builder.hpp"
#include "model/dynamics/tissue_grid.hpp"
#include "model/dynamics/voxel_tissue.hpp"

namespace palpate {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Two neighbours of x on a row of n nodes a apart and centred on 0, with linear weights.
struct Neighbours {
  int low = 0;
  double share = 0.0;  ///< of low + 1
};
Neighbours neighbours(double x, int n, double a) {
  const double at = std::clamp(x / a + 0.5 * (n - 1), 0.0, static_cast<double>(n - 1));
  const int low = std::min(static_cast<int>(at), n - 2);
  return {low, at - low};
}

/// Distance of neighbouring nodes: the median over the nodes of each one's shortest spring [m].
double node_spacing(const SpringNetwork& network) {
  std::vector<double> shortest(static_cast<std::size_t>(network.node_count()),
                               std::numeric_limits<double>::infinity());
  for (const Spring& s : network.springs) {
    for (const int node : {s.a, s.b}) {
      double& least = shortest[static_cast<std::size_t>(node)];
      if (s.rest_length > 0.0) { least = std::min(least, s.rest_length); }
    }
  }
  if (shortest.empty()) { return 0.0; }
  const auto middle = shortest.begin() + static_cast<std::ptrdiff_t>(shortest.size() / 2);
  std::ranges::nth_element(shortest, middle);
  return *middle;
}

}  // namespace

void NeedlePath::add_knot(double depth, const std::vector<Support>& supports) {
  knots_.push_back({depth, supports_.size(), supports.size()});
  supports_.insert(supports_.end(), supports.begin(), supports.end());
}

void NeedlePath::lattice_knots(const Scene& scene, const SpringNetwork& network) {
  const bool layered = scene.tissue.source == Source::layers;
  const double a = layered ? scene.tissue.block.spacing : scene.tissue.lattice.spacing;
  const int nx = layered ? scene.tissue.block.nodes[0] : scene.tissue.lattice.nodes[0];
  const int ny = layered ? scene.tissue.block.nodes[1] : scene.tissue.lattice.nodes[1];
  const int planes = static_cast<int>(network.node_count()) / (nx * ny);
  for (int l = 0; l < planes; ++l) {
    const double depth = l * a / direction_.z();
    const Vector3d at = origin_ + depth * direction_;
    const double slack = 1e-9 * a;
    if (std::abs(at.x()) > 0.5 * a * (nx - 1) + slack ||
        std::abs(at.y()) > 0.5 * a * (ny - 1) + slack) {
      break;  // the line leaves the block
    }
    const Neighbours x = neighbours(at.x(), nx, a);
    const Neighbours y = neighbours(at.y(), ny, a);
    std::vector<Support> supports;
    for (int j = 0; j < 2; ++j) {
      for (int i = 0; i < 2; ++i) {
        const double weight = (i == 0 ? 1.0 - x.share : x.share) * (j == 0 ? 1.0 - y.share : y.share);
        if (weight > 1e-12) { supports.push_back({(l * ny + y.low + j) * nx + x.low + i, weight}); }
      }
    }
    add_knot(depth, supports);
  }
}

void NeedlePath::network_knots(const SpringNetwork& network) {
  const double reach = node_spacing(network);
  struct Near {
    double depth;
    Support support;
  };
  std::vector<Near> near;
  for (Index i = 0; i < network.node_count(); ++i) {
    const Vector3d from = network.rest_position.col(i) - origin_;
    const double depth = from.dot(direction_);
    const double weight = 1.0 - (from - depth * direction_).norm() / reach;
    if (weight > 1e-12) { near.push_back({depth, {static_cast<int>(i), weight}}); }
  }
  std::ranges::sort(near, {}, [](const Near& n) { return std::pair(n.depth, n.support.node); });
  for (std::size_t begin = 0; begin < near.size();) {
    std::size_t end = begin;
    double weight = 0.0;
    double depth = 0.0;
    std::vector<Support> supports;
    for (; end < near.size() && near[end].depth - near[begin].depth <= 0.5 * reach; ++end) {
      supports.push_back(near[end].support);
      weight += near[end].support.weight;
      depth += near[end].support.weight * near[end].depth;
    }
    for (Support& s : supports) { s.weight /= weight; }
    add_knot(depth / weight, supports);
    begin = end;
  }
}

void NeedlePath::grid_knots(const NodeGrid& grid) {
  for (const PlaneCrossing& crossing : plane_crossings(grid, origin_, direction_)) {
    add_knot(crossing.depth, crossing.supports);
  }
}

void NeedlePath::cut_into_pieces() {
  for (std::size_t k = 0; k + 1 < knots_.size(); ++k) {
    for (const PathInterval& interval : intervals_) {
      const double begin = std::max(knots_[k].depth, interval.begin);
      const double end = std::min(knots_[k + 1].depth, interval.end);
      if (end > begin) { pieces_.push_back({begin, end, interval.friction, k}); }
    }
  }
  for (const PathInterval& interval : intervals_) {
    if (interval.role == TissueRole::bone) {
      bone_ = interval.begin;
      break;
    }
  }
}

NeedlePath NeedlePath::of_needle(const Scene& scene, const SpringNetwork& network) {
  NeedlePath path;
  path.origin_ = {scene.needle->entry.x(), scene.needle->entry.y(), 0.0};
  path.direction_ = scene.needle->direction.normalized();
  if (const std::optional<NodeGrid> grid = uneven_grid(scene)) {
    path.grid_knots(*grid);
  } else if (scene.tissue.source == Source::network) {
    path.network_knots(network);
  } else {
    path.lattice_knots(scene, network);
  }
  if (path.knots_.empty()) { throw std::invalid_argument("no node lies near the needle's line"); }
  path.intervals_ =
      intervals_along(scene, path.origin_, path.direction_, path.knots_.front().depth);
  path.cut_into_pieces();
  return path;
}

NeedlePath NeedlePath::of_probe(const Scene& scene, const SpringNetwork& network) {
  NeedlePath path;
  const Probe& probe = *scene.probe;
  path.origin_ = {probe.entry.x(), probe.entry.y(), 0.0};
  const std::optional<NodeGrid> grid = uneven_grid(scene);
  const std::vector<int> skin = grid ? skin_nodes(*grid) : face_nodes(network.rest_position, Face::z_min);
  const Eigen::Vector2d a =
      grid ? Eigen::Vector2d(grid->spacing.head<2>()) : Eigen::Vector2d::Constant(node_spacing(network));
  std::vector<Support> supports;
  double depth = 0.0;
  double total = 0.0;
  // A node's share is how much of its own square of skin, a wide, the footprint covers: sampled.
  constexpr int samples = 16;
  for (const int node : skin) {
    const Vector3d at = network.rest_position.col(node) - path.origin_;
    int covered = 0;
    for (int j = 0; j < samples; ++j) {
      for (int i = 0; i < samples; ++i) {
        const double x = at.x() + a.x() * ((i + 0.5) / samples - 0.5);
        const double y = at.y() + a.y() * ((j + 0.5) / samples - 0.5);
        const bool inside = probe.shape == Probe::Shape::fingertip
                                ? std::hypot(x, y) <= 0.5 * probe.size.x()
                                : std::abs(x) <= 0.5 * probe.size.x() &&
                                      std::abs(y) <= 0.5 * probe.size.y();
        covered += inside ? 1 : 0;
      }
    }
    if (covered == 0) { continue; }
    supports.push_back({node, static_cast<double>(covered)});
    total += covered;
    depth += covered * at.z();
  }
  const bool free = std::ranges::any_of(
      supports, [&](const Support& s) { return !network.is_fixed(s.node); });
  if (!free) { throw std::invalid_argument("no free node lies beneath the probe"); }
  for (Support& s : supports) { s.weight /= total; }
  path.add_knot(depth / total, supports);
  path.intervals_ = {{.cutting_force = std::numeric_limits<double>::infinity(),
                      .label = intervals_along(scene, path.origin_, path.direction_, depth / total)
                                   .front()
                                   .label}};
  path.intervals_.front().begin = depth / total;
  return path;
}

NeedlePath tool_path(const Scene& scene, const SpringNetwork& network) {
  return scene.needle ? NeedlePath::of_needle(scene, network)
                      : NeedlePath::of_probe(scene, network);
}

NeedlePath::Place NeedlePath::place(double depth) const noexcept {
  std::size_t k = 0;
  while (k + 1 < knots_.size() && knots_[k + 1].depth <= depth) { ++k; }
  if (k + 1 == knots_.size()) { return {k, 0.0}; }
  const double share = (depth - knots_[k].depth) / (knots_[k + 1].depth - knots_[k].depth);
  return {k, std::max(share, 0.0)};
}

std::size_t NeedlePath::interval_at(double depth) const noexcept {
  std::size_t n = 0;
  while (n + 1 < intervals_.size() && intervals_[n].end <= depth) { ++n; }
  return n;
}

double NeedlePath::friction(double depth, std::span<double> of_knot) const noexcept {
  std::ranges::fill(of_knot, 0.0);
  double total = 0.0;
  for (const Piece& piece : pieces_) {
    if (piece.begin >= depth) { break; }
    const double end = std::min(piece.end, depth);
    const double force = piece.friction * (end - piece.begin);
    const Knot& low = knots_[piece.knot];
    const Knot& high = knots_[piece.knot + 1];
    const double share = (0.5 * (piece.begin + end) - low.depth) / (high.depth - low.depth);
    of_knot[piece.knot] += (1.0 - share) * force;
    of_knot[piece.knot + 1] += share * force;
    total += force;
  }
  return total;
}

}  // namespace palpate
