// SPDX-License-Identifier: MIT
#pragma once
/// Codes of the materials of a voxel tissue; each material has one code.

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "model/tissue/lattice.hpp"
#include "model/tissue/scene_check.hpp"
#include "model/tissue/voxel_tissue.hpp"

namespace palpate {

class VoxelMaterials {
 public:
  explicit VoxelMaterials(const std::vector<Material>& known) : known_(known) {}

  /// Returns the code of a material for VoxelTissue::material. For an unknown name it returns 0 and
  /// adds a violation of `key`.
  std::uint16_t code_of(const std::string& name, const std::string& key,
                        std::vector<Violation>& broken) {
    const auto used = std::ranges::find(names_, name);
    if (used != names_.end()) { return static_cast<std::uint16_t>(used - names_.begin() + 1); }
    const Material* found = find_material(known_, name);
    if (found == nullptr) {
      broken.push_back({key, unknown_material(name, known_)});
      return 0;
    }
    names_.push_back(name);
    cells_.push_back(
        {found->youngs_modulus, found->density, found->damping_ratio, found->viscosity});
    bone_.push_back(role_of(*found) == TissueRole::bone);
    return static_cast<std::uint16_t>(names_.size());
  }
  [[nodiscard]] const CellMaterial& cell(std::uint16_t code) const { return cells_[code - 1U]; }
  [[nodiscard]] bool bone(std::uint16_t code) const { return code != 0 && bone_[code - 1U]; }
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }

 private:
  const std::vector<Material>& known_;
  std::vector<std::string> names_{};
  std::vector<CellMaterial> cells_{};
  std::vector<bool> bone_{};
};

// Network of the existing nodes of a grid. Each bond is the sum over the cells around it
// (model/EQUATIONS.md, "Material to springs", "Springs of a box").

namespace grid {

template <class Visit> void for_each_node(const NodeGrid& nodes, Visit visit) {
  for (int l = 0; l < nodes.count[2]; ++l) {
    for (int j = 0; j < nodes.count[1]; ++j) {
      for (int i = 0; i < nodes.count[0]; ++i) {
        if (nodes.at(i, j, l) >= 0) { visit(std::array{i, j, l}, nodes.at(i, j, l)); }
      }
    }
  }
}

}  // namespace grid

/// Builds the network. `cell(i, j, l, a, b)` returns the material of a cell for the bond between
/// network nodes a and b, or null if the cell is empty; with a == b the material is used for the
/// mass of that node. The grid must not contain nodes without mass.
template <class Cell>
SpringNetwork grid_network(const NodeGrid& nodes, int connectivity, Cell cell) {
  SpringNetwork network;
  const auto count = std::ranges::count_if(nodes.node, [](int node) { return node >= 0; });
  network.rest_position.resize(3, count);
  network.mass = Eigen::VectorXd::Zero(count);
  network.fixed.assign(static_cast<std::size_t>(count), 0);
  const double volume = nodes.spacing.prod();
  grid::for_each_node(nodes, [&](const std::array<int, 3>& at, int node) {
    network.rest_position.col(node) = nodes.place(at[0], at[1], at[2]);
    for_each_cell_around(nodes.count, at, {0, 0, 0}, [&](int i, int j, int l) {
      const CellMaterial* material = cell(i, j, l, node, node);
      if (material != nullptr) { network.mass(node) += material->density * volume / 8.0; }
    });
  });
  if (count == static_cast<std::ptrdiff_t>(nodes.node.size())) {
    network.springs =
        springs_of_lattice({nodes.count, nodes.spacing.x(), connectivity}, network.rest_position);
  }
  const BoxBonds bonds = box_bonds(nodes.spacing, connectivity);
  const auto directions = bond_directions(connectivity);
  grid::for_each_node(nodes, [&](const std::array<int, 3>& at, int node) {
    for (std::size_t d = 0; d < directions.size(); ++d) {
      const auto& step = directions[d];
      const std::array<int, 3> to{at[0] + step[0], at[1] + step[1], at[2] + step[2]};
      const bool there = to[0] >= 0 && to[1] >= 0 && to[0] < nodes.count[0] &&
                         to[1] < nodes.count[1] && to[2] < nodes.count[2];
      const int neighbour = there ? nodes.at(to[0], to[1], to[2]) : -1;
      if (neighbour < 0 || bonds.stiffness[d] <= 0.0) { continue; }
      const int axes = std::abs(step[0]) + std::abs(step[1]) + std::abs(step[2]);
      const double share = bonds.stiffness[d] / (axes == 1 ? 4.0 : axes == 2 ? 2.0 : 1.0);
      BondSum bond;
      for_each_cell_around(nodes.count, at, step, [&](int i, int j, int l) {
        const CellMaterial* material = cell(i, j, l, node, neighbour);
        if (material != nullptr) { bond.add(share * material->youngs_modulus, *material); }
      });
      if (bond.stiffness <= 0.0) { continue; }
      const double rest =
          nodes.spacing.cwiseProduct(Eigen::Vector3d(step[0], step[1], step[2])).norm();
      network.springs.push_back({node, neighbour, bond.stiffness,
                                 bond.viscosity(network.mass(node), network.mass(neighbour)),
                                 rest});
    }
  });
  return network;
}

}  // namespace palpate
