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

/// z of the skin above the middle of every column of cells, x fastest; infinite where there is none.
std::vector<double> tops_of_columns(const Skin& skin, const LatticeShape& shape) {
  std::vector<double> tops;
  for (int j = 0; j + 1 < shape.nodes[1]; ++j) {
    for (int i = 0; i + 1 < shape.nodes[0]; ++i) {
      const Eigen::Vector3d middle = 0.5 * (shape.position(i, j, 0) + shape.position(i + 1, j + 1, 0));
      tops.push_back(skin.top(middle.x(), middle.y()).value_or(infinity));
    }
  }
  return tops;
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
  const double highest = std::ranges::min(tops_of_columns(*scene.tissue.skin, shape));
  const double bottom = shape.spacing * (shape.nodes[2] - 1);
  if (!(highest < bottom)) { return 0.0; }
  return std::ceil((bottom - highest) / shape.spacing + 1.0) * shape.nodes[0] * shape.nodes[1];
}

BlockBeneathSkin block_beneath_skin(const Scene& scene) {
  const LatticeShape shape = block_shape(scene);
  const double a = shape.spacing;
  const int bottom = shape.nodes[2] - 1;
  // Cell l of a column lies beneath the skin where its middle, (l + 1/2) a, does; a flat skin in a plane of
  // nodes is there but for rounding.
  BlockBeneathSkin block;
  for (const double top : tops_of_columns(*scene.tissue.skin, shape)) {
    const bool tissue = top < bottom * a;
    block.first_cell.push_back(tissue ? std::min(bottom, static_cast<int>(std::ceil(top / a - 0.5 - 1e-9))) : bottom);
  }
  const int above = std::ranges::min(block.first_cell);
  if (above == bottom) { return {}; }
  NodeGrid& grid = block.nodes;
  grid = {.first = shape.position(0, 0, 0) + Eigen::Vector3d(0.0, 0.0, above * a),
          .spacing = Eigen::Vector3d::Constant(a),
          .count = {shape.nodes[0], shape.nodes[1], bottom - above + 1}};
  grid.node.assign(grid.index(0, 0, grid.count[2]), -1);
  for (int& first : block.first_cell) { first -= above; }
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

std::optional<NodeGrid> tissue_grid(const Scene& scene) {
  const Tissue& tissue = scene.tissue;
  switch (tissue.source) {
    case Source::lattice: return grid_of({tissue.lattice.nodes, tissue.lattice.spacing, tissue.lattice.connectivity});
    case Source::layers: return layers_follow_skin(scene) ? block_beneath_skin(scene).nodes : grid_of(block_shape(scene));
    case Source::mesh:
    case Source::mri: return tissue.voxels->nodes;
    case Source::network:
    case Source::oscillator: break;
  }
  return {};
}

}  // namespace palpate
