// SPDX-License-Identifier: MIT
#include "reference/track_knots.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include "model/dynamics/lattice.hpp"
#include "model/dynamics/network_builder.hpp"
#include "reference/solution.hpp"

namespace palpate::reference {

namespace {

using Eigen::Vector3d;

constexpr double rounding = 1e-9;  ///< of a place, in units of the spacing

struct Grid {
  int nx = 0;
  int ny = 0;
  int nz = 0;
  double spacing = 0.0;  ///< [m]
};

std::optional<Grid> grid_of(const Scene& scene, const SpringNetwork& network) {
  const Tissue& tissue = scene.tissue;
  if (tissue.source == Source::lattice) {
    const auto& n = tissue.lattice.nodes;
    return Grid{n[0], n[1], n[2], tissue.lattice.spacing};
  }
  if (tissue.source != Source::layers) { return std::nullopt; }
  const auto& n = tissue.block.nodes;
  return Grid{n[0], n[1], static_cast<int>(network.node_count()) / (n[0] * n[1]),
              tissue.block.spacing};
}

/// Cell and share of a place along one axis with `count` nodes from `first` on.
std::optional<std::pair<int, double>> cell_of(double place, double first, double spacing,
                                              int count) {
  const double steps = (place - first) / spacing;
  if (steps < -rounding || steps > count - 1 + rounding) { return std::nullopt; }
  const int cell = std::clamp(static_cast<int>(std::floor(steps)), 0, count - 2);
  return std::pair{cell, std::clamp(steps - cell, 0.0, 1.0)};
}

std::vector<TrackKnot> lattice_knots(const Needle& needle, const Grid& grid,
                                     const SpringNetwork& network) {
  const Vector3d n = needle.direction.normalized();
  std::vector<TrackKnot> knots;
  for (int l = 0; l < grid.nz; ++l) {
    const int corner = l * grid.nx * grid.ny;
    const Vector3d first = network.rest_position.col(corner);
    TrackKnot knot{.depth = first.z() / n.z()};
    const auto x = cell_of(needle.entry.x() + knot.depth * n.x(), first.x(), grid.spacing, grid.nx);
    const auto y = cell_of(needle.entry.y() + knot.depth * n.y(), first.y(), grid.spacing, grid.ny);
    if (!x || !y) { continue; }
    const int node = corner + y->first * grid.nx + x->first;
    const auto add = [&](int index, double weight) {
      if (weight > rounding) { knot.supports.push_back({index, weight}); }
    };
    add(node, (1.0 - x->second) * (1.0 - y->second));
    add(node + 1, x->second * (1.0 - y->second));
    add(node + grid.nx, (1.0 - x->second) * y->second);
    add(node + grid.nx + 1, x->second * y->second);
    knots.push_back(std::move(knot));
  }
  return knots;
}

double median_length(const SpringNetwork& network) {
  std::vector<double> lengths;
  for (const Spring& spring : network.springs) { lengths.push_back(spring.rest_length); }
  if (lengths.empty()) { throw SolverError("insertion: a network without springs has no scale"); }
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::ranges::nth_element(lengths, middle);
  return *middle;
}

/// Weights that sum to 1, and the weighted mean depth.
TrackKnot knot_of(const std::vector<TrackSupport>& supports, const SpringNetwork& network,
                  const Vector3d& entry, const Vector3d& n) {
  TrackKnot knot{.supports = supports};
  const double sum = std::transform_reduce(supports.begin(), supports.end(), 0.0, std::plus<>(),
                                           [](const TrackSupport& s) { return s.weight; });
  for (TrackSupport& support : knot.supports) {
    support.weight /= sum;
    knot.depth += support.weight * n.dot(network.rest_position.col(support.node) - entry);
  }
  return knot;
}

std::vector<TrackKnot> network_knots(const Needle& needle, const SpringNetwork& network) {
  const Vector3d n = needle.direction.normalized();
  const Vector3d entry{needle.entry.x(), needle.entry.y(), 0.0};
  const double radius = median_length(network);
  std::vector<TrackSupport> near;
  double first = std::numeric_limits<double>::infinity();
  for (int i = 0; i < static_cast<int>(network.node_count()); ++i) {
    const Vector3d from = network.rest_position.col(i) - entry;
    const double away = (from - n.dot(from) * n).norm();
    if (away >= (1.0 - rounding) * radius) { continue; }
    near.push_back({i, 1.0 - away / radius});
    first = std::min(first, n.dot(from));
  }
  std::map<long, std::vector<TrackSupport>> slabs;
  for (const TrackSupport& support : near) {
    const double depth = n.dot(network.rest_position.col(support.node) - entry);
    slabs[std::lround(std::floor((depth - first) / (0.5 * radius) + rounding))].push_back(support);
  }
  std::vector<TrackKnot> knots;
  for (const auto& [number, supports] : slabs) {
    knots.push_back(knot_of(supports, network, entry, n));
  }
  return knots;
}

/// Area of the part of [x0, x1] x [y0, y1] within the probe's footprint, about its centre [m^2].
double covered(const Probe& probe, double x0, double x1, double y0, double y1) {
  const Eigen::Vector2d half = 0.5 * probe.size;
  const bool disc = probe.shape == Probe::Shape::fingertip;
  x0 = std::max(x0, -half.x());
  x1 = std::min(x1, half.x());
  if (x1 <= x0) { return 0.0; }
  constexpr int strips = 20000;  // midpoints: 1e-6 of a disc
  double area = 0.0;
  for (int n = 0; n < (disc ? strips : 1); ++n) {
    const double width = (x1 - x0) / (disc ? strips : 1);
    const double x = x0 + (n + 0.5) * width;
    const double reach = disc ? std::sqrt(half.x() * half.x() - x * x) : half.y();
    area += width * std::max(0.0, std::min(y1, reach) - std::max(y0, -reach));
  }
  return area;
}

}  // namespace

std::vector<TrackKnot> needle_knots(const Scene& scene, const SpringNetwork& network) {
  if (const auto grid = grid_of(scene, network)) {
    return lattice_knots(*scene.needle, *grid, network);
  }
  return network_knots(*scene.needle, network);
}

TrackKnot probe_knot(const Scene& scene, const SpringNetwork& network) {
  const Probe& probe = *scene.probe;
  const auto grid = grid_of(scene, network);
  const auto skin = face_nodes(network.rest_position, Face::z_min);
  const auto low = network.rest_position.rowwise().minCoeff().eval();
  const auto high = network.rest_position.rowwise().maxCoeff().eval();
  std::vector<TrackSupport> supports;
  for (const int node : skin) {
    const Vector3d at = network.rest_position.col(node);
    const Eigen::Vector2d from = at.head<2>() - probe.entry;
    const double reach = grid ? 0.5 * grid->spacing : 0.0;
    double weight = 0.0;
    if (grid) {
      weight = covered(probe, std::max(at.x() - reach, low.x()) - probe.entry.x(),
                       std::min(at.x() + reach, high.x()) - probe.entry.x(),
                       std::max(at.y() - reach, low.y()) - probe.entry.y(),
                       std::min(at.y() + reach, high.y()) - probe.entry.y());
    } else if (probe.shape == Probe::Shape::fingertip) {
      weight = from.norm() <= 0.5 * probe.size.x() ? 1.0 : 0.0;
    } else {
      weight = (from.cwiseAbs() - 0.5 * probe.size).maxCoeff() <= 0.0 ? 1.0 : 0.0;
    }
    if (weight > 0.0) { supports.push_back({node, weight}); }
  }
  if (supports.empty()) { throw SolverError("insertion: no node lies beneath the probe"); }
  return knot_of(supports, network, Vector3d::Zero(), Vector3d::UnitZ());
}

}  // namespace palpate::reference
