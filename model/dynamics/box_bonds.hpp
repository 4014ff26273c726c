// SPDX-License-Identifier: MIT
#pragma once
/// Springs of a grid whose boxes need not be cubes (model/EQUATIONS.md, "Springs of a box").

#include <array>

#include <Eigen/Core>

namespace palpate {

/// Stiffness of whole bonds per unit of Young's modulus [m], in the order of bond_directions(): edges,
/// face diagonals, body diagonals. A box has a quarter of each of its edges, half of each face diagonal.
struct BoxBonds {
  std::array<double, 13> stiffness{};
  Eigen::Matrix3d elasticity = Eigen::Matrix3d::Zero();  ///< C_nn, C_nm of axes n, m per unit of E [1]

  /// Young's modulus of the homogenised grid along each axis per unit of that asked for [1].
  [[nodiscard]] Eigen::Vector3d youngs_moduli() const;
};

/// For a box of these edges [m]. Cubes are those of bond_stiffness(). Where constants that are not
/// negative can make the grid isotropic (nu = 1/4) they do: for 26 neighbours as long as no edge
/// is more than about 1.7 of another; beyond, the constants that come nearest in the least squares of
/// C_nm are taken, and elasticity says what came out. 6 neighbours have C_nn = E and no shear.
BoxBonds box_bonds(const Eigen::Vector3d& size, int connectivity);

}  // namespace palpate
