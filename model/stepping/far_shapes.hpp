// SPDX-License-Identifier: MIT
#pragma once
/// The few shapes in which tissue away from a tool is left to move (model/EQUATIONS.md, "Far field").

#include <vector>

#include <Eigen/Core>

#include "model/stepping/near_nodes.hpp"
#include "model/stepping/pushes.hpp"

namespace palpate {

/// What is left to a far field: all but what is near to what is pushed.
struct FarFieldSetting {
  NearNodes near{};
  std::vector<Push> pushes{};
  int modes = 0;  ///< at most
};

/// A far node moves by phi^T z, z the coordinates of the shapes: phi has 3 columns, of modes() numbers each.
struct FarShapes {
  std::vector<std::ptrdiff_t> column{};  ///< first of each node; -1: a near node, or a held one
  Eigen::MatrixXd phi{};                 ///< modes x 3 far nodes
  double mass = 0.0;                     ///< of each shape: that of a mean far node [kg]
  [[nodiscard]] Eigen::Index modes() const { return phi.rows(); }
  /// The columns of a node, or nothing that moves.
  [[nodiscard]] bool holds(int node) const { return column[static_cast<std::size_t>(node)] >= 0; }
  [[nodiscard]] auto of(int node) const { return phi.middleCols<3>(column[static_cast<std::size_t>(node)]); }
};

/// `shape` is lattice_of() the problem's network.
FarShapes far_shapes(const NetworkProblem& problem, const LatticeShape& shape, const FarFieldSetting& setting);

}  // namespace palpate
