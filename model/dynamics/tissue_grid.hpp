// SPDX-License-Identifier: MIT
#pragma once
/// The grid that the nodes of a scene's tissue lie on.

#include <optional>
#include <vector>

#include "model/dynamics/lattice.hpp"
#include "model/dynamics/node_grid.hpp"
#include "model/dynamics/scene.hpp"

namespace palpate {

/// The block of layers as it is under a flat skin: as many cells deep as come nearest to their thickness.
LatticeShape block_shape(const Scene& scene);

/// Whether layers lie beneath a skin that need not be flat.
bool layers_follow_skin(const Scene& scene);

/// The block's cells whose middle is beneath the skin, from the highest place of the skin above the block
/// down to where a flat block ends, or the body does (model/EQUATIONS.md, "Layers beneath a skin").
struct BlockBeneathSkin {
  NodeGrid nodes{};               ///< without any where none of the skin lies above the block
  struct Column {
    int begin = 0;
    int end = 0;
  };
  std::vector<Column> columns{};  ///< cells of tissue, [begin, end) in planes of `nodes`; x fastest

  [[nodiscard]] bool holds(int i, int j, int l) const {
    const Column& column = columns[static_cast<std::size_t>(j) * static_cast<std::size_t>(nodes.count[0] - 1) +
                                   static_cast<std::size_t>(i)];
    return l >= column.begin && l < column.end;
  }
  /// Share of the block's columns that have tissue.
  [[nodiscard]] double covered() const;
};

/// Of a scene whose layers follow a skin and take at most `most_nodes` of scene_check.hpp.
BlockBeneathSkin block_beneath_skin(const Scene& scene);

/// Places on the grid that block_beneath_skin lays, some of them empty.
double places_beneath_skin(const Scene& scene);

/// The grid of a tissue whose skin need not be flat; nothing for others.
std::optional<NodeGrid> uneven_grid(const Scene& scene);

/// With the nodes numbered as in build_network(scene). Nothing for a bare network and an oscillator.
std::optional<NodeGrid> tissue_grid(const Scene& scene);

}  // namespace palpate
