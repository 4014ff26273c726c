// SPDX-License-Identifier: MIT
#pragma once
/// What the cells around a bond add up to (model/EQUATIONS.md, "Material to springs").

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <span>

#include "model/problem/scene.hpp"
#include "model/problem/spring_network.hpp"

namespace palpate {

/// What fills one cell.
struct CellMaterial {
  double youngs_modulus = 0.0;        ///< [Pa]
  double density = 0.0;               ///< [kg/m^3]
  double damping_ratio = 0.0;         ///< [1]
  std::optional<double> viscosity{};  ///< [N s/m] per spring; wins over damping_ratio
};

/// Stiffness adds up; damping is the mean of the cells' by what they bring of the stiffness.
struct BondSum {
  double stiffness = 0.0;
  double damping_ratio_sum = 0.0;  ///< weighted by stiffness
  double viscosity_sum = 0.0;      ///< weighted by stiffness

  void add(double share, const CellMaterial& material) {
    stiffness += share;
    if (material.viscosity) {
      viscosity_sum += share * *material.viscosity;
    } else {
      damping_ratio_sum += share * material.damping_ratio;
    }
  }
  /// [N s/m] between nodes of these masses [kg]
  [[nodiscard]] double viscosity(double mass_a, double mass_b) const {
    const double reduced_mass = mass_a * mass_b / (mass_a + mass_b);
    const double critical = 2.0 * std::sqrt(stiffness * reduced_mass);
    return (damping_ratio_sum * critical + viscosity_sum) / stiffness;
  }
};

// Cells of a grid around a bond between two of its nodes.

/// Calls visit(i, j, l) for the cells that hold both the node at `a` and that at a + step, in the
/// order of their index; cell (i, j, l) has node (i, j, l) at its corner of least coordinates.
/// `nodes`: of the grid along each axis.
template <class Visit>
void for_each_cell_around(const std::array<int, 3>& nodes, const std::array<int, 3>& a,
                          const std::array<int, 3>& step, Visit visit) {
  std::array<int, 3> low{};
  std::array<int, 3> high{};
  for (std::size_t n = 0; n < 3; ++n) {
    low[n] = std::max(step[n] == 1 ? a[n] : a[n] - 1, 0);
    high[n] = std::min(step[n] == -1 ? a[n] - 1 : a[n], nodes[n] - 2);
  }
  for (int l = low[2]; l <= high[2]; ++l) {
    for (int j = low[1]; j <= high[1]; ++j) {
      for (int i = low[0]; i <= high[0]; ++i) { visit(i, j, l); }
    }
  }
}

// Regular lattices, built cell by cell (model/EQUATIONS.md, "Material to springs").

/// An empty list between the nodes of a lattice whose nodes are at `position`.
SpringList springs_of_lattice(const LatticeShape& shape, const NodeVectors& position);

/// Gives a network that was not built as a lattice the structure of one, if its nodes and springs
/// are those of a regular lattice to rounding.
void recognise_lattice(SpringNetwork& network);

/// Offsets (i, j, l) of the neighbours with a higher index: 3, 9 or 13 of them.
std::span<const std::array<int, 3>> bond_directions(int connectivity);

/// Each cell carries its edges at k1/4, face diagonals at k2/2, body diagonals at k3 and an eighth
/// of its mass at each corner; members shared by cells add up. cell(i, j, l) is asked once a cell.
SpringNetwork cell_lattice(const LatticeShape& shape,
                           const std::function<CellMaterial(int, int, int)>& cell);

/// One stiffness, viscosity and node mass for all.
SpringNetwork uniform_lattice(const LatticeShape& shape, double stiffness, double viscosity,
                              double node_mass);

// Springs of a grid whose boxes need not be cubes (model/EQUATIONS.md, "Springs of a box").

/// Stiffness of whole bonds per unit of Young's modulus [m], in the order of bond_directions():
/// edges, face diagonals, body diagonals. A box has a quarter of each of its edges, half of each
/// face diagonal.
struct BoxBonds {
  std::array<double, 13> stiffness{};
  Eigen::Matrix3d elasticity =
      Eigen::Matrix3d::Zero();  ///< C_nn, C_nm of axes n, m per unit of E [1]

  /// Young's modulus of the homogenised grid along each axis per unit of that asked for [1].
  [[nodiscard]] Eigen::Vector3d youngs_moduli() const;
};

/// For a box of these edges [m]. Cubes are those of bond_stiffness(). Where constants that are not
/// negative can make the grid isotropic (nu = 1/4) they do: for 26 neighbours as long as no edge
/// is more than about 1.7 of another; beyond, the constants that come nearest in the least squares
/// of C_nm are taken, and elasticity says what came out. 6 neighbours have C_nn = E and no shear.
BoxBonds box_bonds(const Eigen::Vector3d& size, int connectivity);

}  // namespace palpate
