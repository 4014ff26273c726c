// SPDX-License-Identifier: MIT
#include "model/dynamics/tissue_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "model/dynamics/skin.hpp"
#include "model/dynamics/voxel_tissue.hpp"

namespace palpate {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Where the middle of every column of cells is beneath the skin, x fastest; empty from infinity on.
std::vector<Skin::Stretch> stretches_of_columns(const Skin& skin, const LatticeShape& shape) {
  std::vector<Skin::Stretch> stretches;
  for (int j = 0; j + 1 < shape.nodes[1]; ++j) {
    for (int i = 0; i + 1 < shape.nodes[0]; ++i) {
      const Eigen::Vector3d middle = 0.5 * (shape.position(i, j, 0) + shape.position(i + 1, j + 1, 0));
      stretches.push_back(skin.beneath(middle.x(), middle.y()).value_or(Skin::Stretch{.top = infinity}));
    }
  }
  return stretches;
}

NodeGrid grid_of(const LatticeShape& shape) {
  NodeGrid grid{.first = shape.position(0, 0, 0),
                .spacing = Eigen::Vector3d::Constant(shape.spacing),
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

bool layers_follow_skin(const Scene& scene) {
  const Tissue& tissue = scene.tissue;
  return tissue.source == Source::layers && tissue.skin && tissue.skin->shapes_layers();
}

double places_beneath_skin(const Scene& scene) {
  const LatticeShape shape = block_shape(scene);
  const double highest =
      std::ranges::min(stretches_of_columns(*scene.tissue.skin, shape), {}, &Skin::Stretch::top).top;
  const double bottom = shape.spacing * (shape.nodes[2] - 1);
  if (!(highest < bottom)) { return 0.0; }
  return std::ceil((bottom - highest) / shape.spacing + 1.0) * shape.nodes[0] * shape.nodes[1];
}

double BlockBeneathSkin::covered() const {
  const auto filled = std::ranges::count_if(columns, [](const Column& c) { return c.begin < c.end; });
  return static_cast<double>(filled) / static_cast<double>(std::max<std::size_t>(columns.size(), 1));
}

BlockBeneathSkin block_beneath_skin(const Scene& scene) {
  const LatticeShape shape = block_shape(scene);
  const double a = shape.spacing;
  const int bottom = shape.nodes[2] - 1;
  // Cell l of a column lies beneath the skin where its middle, (l + 1/2) a, does; a flat skin in a plane of
  // nodes is there but for rounding.
  BlockBeneathSkin block;
  const auto first_below = [&](double z) {
    return z < bottom * a ? std::min(bottom, static_cast<int>(std::ceil(z / a - 0.5 - 1e-9))) : bottom;
  };
  int above = bottom;
  for (const Skin::Stretch& tissue : stretches_of_columns(*scene.tissue.skin, shape)) {
    block.columns.push_back({first_below(tissue.top), first_below(tissue.bottom)});
    if (block.columns.back().begin < block.columns.back().end) { above = std::min(above, block.columns.back().begin); }
  }
  if (above == bottom) { return {}; }
  NodeGrid& grid = block.nodes;
  grid = {.first = shape.position(0, 0, 0) + Eigen::Vector3d(0.0, 0.0, above * a),
          .spacing = Eigen::Vector3d::Constant(a),
          .count = {shape.nodes[0], shape.nodes[1], bottom - above + 1}};
  grid.node.assign(grid.index(0, 0, grid.count[2]), -1);
  for (BlockBeneathSkin::Column& column : block.columns) {
    column.begin -= above;
    column.end -= above;
  }
  for (int l = 0; l + 1 < grid.count[2]; ++l) {
    for (int j = 0; j + 1 < grid.count[1]; ++j) {
      for (int i = 0; i + 1 < grid.count[0]; ++i) {
        if (!block.holds(i, j, l)) { continue; }
        for (int corner = 0; corner < 8; ++corner) {
          grid.node[grid.index(i + (corner & 1), j + ((corner >> 1) & 1), l + (corner >> 2))] = 0;
        }
      }
    }
  }
  number_nodes(grid);
  return block;
}

std::optional<NodeGrid> uneven_grid(const Scene& scene) {
  if (scene.tissue.voxels) { return scene.tissue.voxels->nodes; }
  return layers_follow_skin(scene) ? std::optional(block_beneath_skin(scene).nodes) : std::nullopt;
}

std::optional<NodeGrid> tissue_grid(const Scene& scene) {
  const Tissue& tissue = scene.tissue;
  if (std::optional<NodeGrid> uneven = uneven_grid(scene)) { return uneven; }
  switch (tissue.source) {
    case Source::lattice: return grid_of({tissue.lattice.nodes, tissue.lattice.spacing, tissue.lattice.connectivity});
    case Source::layers: return grid_of(block_shape(scene));
    case Source::mesh:
    case Source::mri:
    case Source::network:
    case Source::oscillator: break;
  }
  return {};
}

}  // namespace palpate
