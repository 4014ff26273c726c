// SPDX-License-Identifier: MIT
#pragma once
/// Regular lattices, built cell by cell (model/EQUATIONS.md, "Material to springs").

#include <array>
#include <functional>
#include <optional>
#include <span>

#include "model/dynamics/bond_sum.hpp"
#include "model/dynamics/scene.hpp"
#include "model/dynamics/spring_network.hpp"

namespace palpate {

struct LatticeShape {
  std::array<int, 3> nodes{};
  double spacing = 0.0;  ///< [m]
  int connectivity = 26;

  [[nodiscard]] int node_count() const { return nodes[0] * nodes[1] * nodes[2]; }
  [[nodiscard]] int index(int i, int j, int l) const { return (l * nodes[1] + j) * nodes[0] + i; }
  [[nodiscard]] std::array<int, 3> place(int node) const {  ///< (i, j, l) of an index
    return {node % nodes[0], node / nodes[0] % nodes[1], node / (nodes[0] * nodes[1])};
  }
  [[nodiscard]] Eigen::Vector3d position(int i, int j, int l) const;  ///< [m]
};

/// The lattice that a network is, whatever it was made from: nodes in the order of index(), at least two
/// along each axis, whichever way it points, and no springs but bonds of 26 neighbours with their natural length (both to
/// rounding; position() is that of the shape, not of the network). Nothing for any other network.
std::optional<LatticeShape> lattice_of(const SpringNetwork& network);

/// Offsets (i, j, l) of the neighbours with a higher index: 3, 9 or 13 of them.
std::span<const std::array<int, 3>> bond_directions(int connectivity);

/// Each cell carries its edges at k1/4, face diagonals at k2/2, body diagonals at k3 and an eighth
/// of its mass at each corner; members shared by cells add up. cell(i, j, l) is asked once a cell.
SpringNetwork cell_lattice(const LatticeShape& shape,
                           const std::function<CellMaterial(int, int, int)>& cell);

/// One stiffness, viscosity and node mass for all.
SpringNetwork uniform_lattice(const LatticeShape& shape, double stiffness, double viscosity,
                              double node_mass);

}  // namespace palpate
