// SPDX-License-Identifier: MIT

#include "model/tissue/tissue_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <ranges>
#include <stdexcept>

#include "model/tissue/skin.hpp"
#include "model/tissue/voxel_tissue.hpp"

namespace palpate {

namespace {

using Eigen::Vector3d;

constexpr double slack = 1e-9;  // of a position, in units of a spacing

/// Linear interpolation of a position along one axis; count 0 if the position is outside.
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
  const auto crossings = plane_crossings(grid, {at.x(), at.y(), 0.0}, Vector3d::UnitZ());
  return crossings.empty() ? std::nullopt : std::optional(crossings.front().depth);
}

std::vector<int> skin_columns(const NodeGrid& grid) {
  std::vector<int> skin;
  for_each_column(grid.count, [&](int i, int j) {
    int l = 0;
    while (l + 1 < grid.count[2] && grid.at(i, j, l) < 0) { ++l; }
    skin.push_back(grid.at(i, j, l));
  });
  return skin;
}

namespace {

/// Returns points of equal force under a rigid flat punch, relative to its axis [m].
std::vector<Eigen::Vector2d> punch_points(double radius) {
  if (!(radius > 0.0)) { return {Eigen::Vector2d::Zero()}; }
  constexpr int rings = 8;
  constexpr int spokes = 16;
  std::vector<Eigen::Vector2d> points;
  for (int ring = 0; ring < rings; ++ring) {
    const double within = (ring + 0.5) / rings;  // part of the force within the ring
    const double r = radius * std::sqrt(within * (2.0 - within));
    for (int spoke = 0; spoke < spokes; ++spoke) {
      const double angle = 2.0 * std::numbers::pi * (spoke + 0.5) / spokes;
      points.emplace_back(r * std::cos(angle), r * std::sin(angle));
    }
  }
  return points;
}

}  // namespace

std::vector<PlaneCrossing> plane_crossings(const NodeGrid& grid, const Vector3d& origin,
                                           const Vector3d& direction, double radius) {
  const std::vector<Eigen::Vector2d> points = punch_points(radius);
  const std::vector<Eigen::Vector2d> on_axis = punch_points(0.0);
  std::vector<PlaneCrossing> crossings;
  for (int l = 0; l < grid.count[2]; ++l) {
    PlaneCrossing crossing{.depth = (grid.first.z() + l * grid.spacing.z() - origin.z()) /
                                    direction.z()};
    const Vector3d axis = origin + crossing.depth * direction;
    double total = 0.0;
    std::map<int, double> weights;
    const auto in_grid = [&](const Eigen::Vector2d& point) {
      return between(axis.x() + point.x(), grid.first.x(), grid.spacing.x(), grid.count[0]).count *
                 between(axis.y() + point.y(), grid.first.y(), grid.spacing.y(), grid.count[1])
                     .count >
             0;
    };
    // A disc that the sides of the grid cut off acts on the axis alone, which keeps its centre.
    const bool whole = std::ranges::all_of(points, in_grid);
    for (const Eigen::Vector2d& point : whole ? points : on_axis) {
      const Eigen::Vector2d at = axis.head<2>() + point;
      const Between x = between(at.x(), grid.first.x(), grid.spacing.x(), grid.count[0]);
      const Between y = between(at.y(), grid.first.y(), grid.spacing.y(), grid.count[1]);
      for (int n = 0; n < x.count * y.count; ++n) {
        const auto i = static_cast<std::size_t>(n % 2);
        const auto j = static_cast<std::size_t>(n / 2);
        const double weight = x.weight[i] * y.weight[j];
        const int node = grid.at(x.at[i], y.at[j], l);
        if (node < 0 || weight <= 1e-12) { continue; }
        weights[node] += weight;
        total += weight;
      }
    }
    if (weights.empty()) { continue; }
    for (const auto& [node, weight] : weights) { crossing.supports.push_back({node, weight}); }
    for (NeedlePath::Support& support : crossing.supports) { support.weight /= total; }
    crossings.push_back(std::move(crossing));
  }
  return crossings;
}

namespace {

/// Returns the interval below the skin at the centre of every column of cells, x fastest; begins at
/// infinity for an empty column.
std::vector<Skin::Stretch> stretches_of_columns(const Skin& skin, const LatticeShape& shape) {
  std::vector<Skin::Stretch> stretches;
  for_each_column(cells_of(shape.nodes), [&](int i, int j) {
    const Vector3d middle = 0.5 * (shape.position(i, j, 0) + shape.position(i + 1, j + 1, 0));
    stretches.push_back(
        skin.beneath(middle.x(), middle.y())
            .value_or(Skin::Stretch{.top = std::numeric_limits<double>::infinity()}));
  });
  return stretches;
}

NodeGrid grid_of(const LatticeShape& shape) {
  NodeGrid grid{.first = shape.position(0, 0, 0),
                .spacing = Vector3d::Constant(shape.spacing),
                .count = shape.nodes};
  grid.node.resize(static_cast<std::size_t>(shape.node_count()));
  std::iota(grid.node.begin(), grid.node.end(), 0);
  return grid;
}

}  // namespace

LatticeShape block_shape(const Scene& scene) {
  const LayerBlock& block = scene.tissue.block;
  const double depth =
      std::transform_reduce(scene.tissue.layers.begin(), scene.tissue.layers.end(), 0.0,
                            std::plus<>(), [](const Layer& layer) { return layer.thickness; });
  const int cells = std::max(1, static_cast<int>(std::lround(depth / block.spacing)));
  return {{block.nodes[0], block.nodes[1], cells + 1}, block.spacing, block.connectivity};
}

std::vector<ResolvedLayer> resolved_layers(const Scene& scene) {
  if (scene.tissue.source != Source::layers || layers_follow_skin(scene)) { return {}; }
  const LatticeShape shape = block_shape(scene);
  const double a = shape.spacing;
  const double bottom = a * (shape.nodes[2] - 1);
  std::vector<ResolvedLayer> layers;
  double begin = 0.0;
  for (const Layer& layer : scene.tissue.layers) {
    const bool last = &layer == &scene.tissue.layers.back();
    const double end = last ? std::max(begin, bottom) : begin + layer.thickness;
    if (layer.gap) {
      begin = end;
      continue;
    }
    const double first = std::ceil(begin / a - slack);
    const double beyond = std::floor(std::min(end, bottom) / a + slack);
    layers.push_back({layer.tissue.empty() ? layer.material : layer.tissue, layer.thickness,
                      std::max(0, static_cast<int>(beyond - first))});
    begin = end;
  }
  return layers;
}

bool layers_follow_skin(const Scene& scene) {
  const Tissue& tissue = scene.tissue;
  return tissue.source == Source::layers && tissue.skin && tissue.skin->shapes_layers();
}

double places_beneath_skin(const Scene& scene) {
  const LatticeShape shape = block_shape(scene);
  const double highest =
      std::ranges::min(stretches_of_columns(*scene.tissue.skin, shape), {}, &Skin::Stretch::top)
          .top;
  const double bottom = shape.spacing * (shape.nodes[2] - 1);
  if (!(highest < bottom)) { return 0.0; }
  return std::ceil((bottom - highest) / shape.spacing + 1.0) * shape.nodes[0] * shape.nodes[1];
}

std::optional<std::array<double, 4>> column_between_sheets(const Scene& scene) {
  const LatticeShape shape = block_shape(scene);
  const auto stretches = stretches_of_columns(*scene.tissue.skin, shape);
  const auto found = std::ranges::find_if(stretches, &Skin::Stretch::between_sheets);
  if (found == stretches.end()) { return {}; }
  const auto column = static_cast<int>(found - stretches.begin());
  const int across = cells_of(shape.nodes)[0];
  const Vector3d corner = shape.position(column % across, column / across, 0);
  return std::array{corner.x() + 0.5 * shape.spacing, corner.y() + 0.5 * shape.spacing, found->top,
                    found->bottom};
}

bool layers_are_uneven(const Scene& scene) {
  return scene.tissue.source == Source::layers &&
         (layers_follow_skin(scene) || std::ranges::any_of(scene.tissue.layers, &Layer::gap));
}

namespace {

/// Planes of cells [begin, end) of one column that lie below the skin and above the body's bottom.
struct Planes {
  int begin = 0;
  int end = 0;
};

/// Returns the planes of each column of cells, x fastest.
std::vector<Planes> planes_of_columns(const Scene& scene, const LatticeShape& shape) {
  const int bottom = shape.nodes[2] - 1;
  std::vector<Planes> columns;
  if (!layers_follow_skin(scene)) {
    for_each_column(cells_of(shape.nodes), [&](int, int) { columns.push_back({0, bottom}); });
    return columns;
  }
  const double a = shape.spacing;
  // Cell l of a column is below the skin if its centre (l + 1/2) a is. A flat skin in a plane of
  // nodes agrees with that plane only to rounding error.
  const auto first_below = [&](double z) {
    return z < bottom * a ? std::min(bottom, static_cast<int>(std::ceil(z / a - 0.5 - 1e-9)))
                          : bottom;
  };
  for (const Skin::Stretch& tissue : stretches_of_columns(*scene.tissue.skin, shape)) {
    columns.push_back({first_below(tissue.top), first_below(tissue.bottom)});
  }
  return columns;
}

}  // namespace

UnevenBlock uneven_block(const Scene& scene) {
  const LatticeShape shape = block_shape(scene);
  const double a = shape.spacing;
  const int bottom = shape.nodes[2] - 1;
  const std::vector<Planes> columns = planes_of_columns(scene, shape);
  int above = bottom;
  std::ptrdiff_t filled = 0;
  for (const Planes& column : columns) {
    if (column.begin >= column.end) { continue; }
    above = std::min(above, column.begin);
    ++filled;
  }
  if (above == bottom) { return {}; }
  UnevenBlock block{.covered = static_cast<double>(filled) / static_cast<double>(columns.size())};
  NodeGrid& grid = block.nodes;
  grid = {.first = shape.position(0, 0, 0) + Vector3d(0.0, 0.0, above * a),
          .spacing = Vector3d::Constant(a),
          .count = {shape.nodes[0], shape.nodes[1], bottom - above + 1}};
  grid.node.assign(grid.index(0, 0, grid.count[2]), -1);
  const std::vector<Layer>& layers = scene.tissue.layers;
  for_each_place(cells_of(grid.count), [&](int i, int j, int l) {
    const Planes& column = columns[grid_index(cells_of(grid.count), i, j, 0)];
    bool tissue = l + above >= column.begin && l + above < column.end;
    if (tissue) {
      const Vector3d centre = grid.place(i, j, l).array() + 0.5 * a;
      tissue = !layers[layer_at(layers, depth_in_layers(scene, centre))].gap ||
               std::ranges::any_of(scene.tissue.inclusions,
                                   [&](const Inclusion& body) { return contains(body, centre); });
    }
    block.cells.push_back(tissue ? 1 : 0);
    if (!tissue) { return; }
    for_each_corner(i, j, l, [&](int b, int c, int d) { grid.node[grid.index(b, c, d)] = 0; });
  });
  number_nodes(grid);
  return block;
}

std::optional<NodeGrid> uneven_grid(const Scene& scene) {
  if (scene.tissue.voxels) { return scene.tissue.voxels->nodes; }
  return layers_are_uneven(scene) ? std::optional(uneven_block(scene).nodes) : std::nullopt;
}

std::optional<NodeGrid> tissue_grid(const Scene& scene) {
  const Tissue& tissue = scene.tissue;
  if (std::optional<NodeGrid> uneven = uneven_grid(scene)) { return uneven; }
  switch (tissue.source) {
    case Source::lattice:
      return grid_of({tissue.lattice.nodes, tissue.lattice.spacing, tissue.lattice.connectivity});
    case Source::layers: return grid_of(block_shape(scene));
    case Source::mesh:
    case Source::mri:
    case Source::network:
    case Source::oscillator: break;
  }
  return {};
}

namespace {

constexpr double on_surface = 1e-9;  // tolerance for points on a surface [m]

const Material& material_named(const Scene& scene, std::string_view name) {
  const Material* found = find_material(scene.materials, name);
  if (found == nullptr) {
    throw std::invalid_argument("no material " +
                                std::string(name));  // check_scene rejects this earlier
  }
  return *found;
}

bool is_bone(const Material& material) { return role_of(material) == TissueRole::bone; }

CellMaterial cell_of(const Material& m) {
  return {m.youngs_modulus, m.density,          m.damping_ratio, m.viscosity,
          m.poissons_ratio, m.retardation_time, law_of(m)};
}

/// Calls visit(material, upper end, lower end) for each layer but gaps; the last one is unbounded.
template <class Visit> void for_each_layer(const Scene& scene, Visit visit) {
  double begin = 0.0;
  const auto& layers = scene.tissue.layers;
  for (std::size_t n = 0; n < layers.size(); ++n) {
    const double end = n + 1 == layers.size() ? std::numeric_limits<double>::infinity()
                                              : begin + layers[n].thickness;
    if (!layers[n].gap) { visit(material_named(scene, layers[n].material), begin, end); }
    begin = end;
  }
}

/// Materials in a cell: the mean of the soft ones, and the last bone.
struct Mixture {
  std::optional<CellMaterial> soft{};
  const Material* bone = nullptr;
};

/// Returns the mean over the layers between top and bottom, weighted by thickness, without bone.
Mixture layered_mixture(const Scene& scene, double top, double bottom) {
  Mixture mixture;
  MaterialMean mean;
  for_each_layer(scene, [&](const Material& m, double begin, double end) {
    const double share = (std::min(bottom, end) - std::max(top, begin)) / (bottom - top);
    if (share <= 0.0) { return; }
    if (is_bone(m)) {
      mixture.bone = &m;
      return;
    }
    mean.add(share, cell_of(m));
  });
  if (mean.parts() * (bottom - top) <= on_surface) { return mixture; }
  mixture.bone = nullptr;
  mixture.soft = mean.mean();
  return mixture;
}

/// Returns the softer inclusion at a corner that is not in bone, for a cell in a layer of bone.
const Material* inclusion_beside_bone(const Scene& scene, const LatticeCell& cell) {
  const Material* found = nullptr;
  for (int n = 0; n < 8; ++n) {
    for (const Inclusion& body : scene.tissue.inclusions) {
      const Material& m = material_named(scene, body.material);
      if (!is_bone(m) && contains(body, cell.corner(n))) { found = &m; }
    }
  }
  return found;
}

}  // namespace

bool contains(const Inclusion& body, const Vector3d& point, double margin) {
  const Vector3d away = point - body.centre;
  if (body.shape == Inclusion::Shape::sphere) {
    return away.norm() <= 0.5 * body.size.x() + margin;
  }
  return (away.cwiseAbs() - 0.5 * body.size).maxCoeff() <= margin;
}

double depth_in_layers(const Scene& scene, const Vector3d& point) {
  return layers_follow_skin(scene) ? scene.tissue.skin->depth(point) : point.z();
}

std::size_t layer_at(const std::vector<Layer>& layers, double depth) {
  std::size_t n = 0;
  for (double end = layers[0].thickness; n + 1 < layers.size() && depth >= end;
       end += layers[n].thickness) {
    ++n;
  }
  return n;
}

CellMaterial cell_material(const Scene& scene, const LatticeCell& cell) {
  const Tissue& tissue = scene.tissue;
  Mixture mixture;
  if (layers_follow_skin(scene)) {
    const double middle =
        tissue.skin->distance(cell.centre());  // called for cells below the skin only
    mixture =
        layered_mixture(scene, std::max(0.0, middle - 0.5 * cell.size), middle + 0.5 * cell.size);
  } else if (tissue.source == Source::layers) {
    mixture = layered_mixture(scene, cell.low.z(), cell.bottom);
  } else {
    mixture.soft = cell_of(material_named(scene, tissue.lattice.material));
  }
  for (const Inclusion& body : tissue.inclusions) {
    if (!contains(body, cell.centre())) { continue; }
    const Material& m = material_named(scene, body.material);
    mixture.bone = is_bone(m) ? &m : nullptr;
    if (mixture.bone == nullptr) { mixture.soft = cell_of(m); }
  }
  if (mixture.bone == nullptr) { return *mixture.soft; }
  const bool all_in_bone = std::ranges::all_of(
      std::views::iota(0, 8), [&](int n) { return in_bone(scene, cell.corner(n)); });
  if (all_in_bone) { return cell_of(*mixture.bone); }
  if (mixture.soft) { return *mixture.soft; }
  const Material* beside = inclusion_beside_bone(scene, cell);
  return cell_of(beside != nullptr ? *beside : *mixture.bone);
}

bool in_bone(const Scene& scene, const Vector3d& point) {
  bool bone = false;
  const double depth = depth_in_layers(scene, point);
  for_each_layer(scene, [&](const Material& m, double top, double bottom) {
    const bool here = depth >= top - on_surface && depth <= bottom + on_surface;
    bone = bone || (here && is_bone(m));
  });
  for (const Inclusion& body : scene.tissue.inclusions) {
    const bool hard = is_bone(material_named(scene, body.material));
    if (contains(body, point, hard ? on_surface : -on_surface)) { bone = hard; }
  }
  return bone;
}

bool has_bone(const Scene& scene) {
  bool bone = false;
  for_each_layer(scene, [&](const Material& m, double, double) { bone = bone || is_bone(m); });
  return bone || std::ranges::any_of(scene.tissue.inclusions, [&](const Inclusion& body) {
           return is_bone(material_named(scene, body.material));
         });
}

}  // namespace palpate
