// SPDX-License-Identifier: MIT
#pragma once
/// A lattice seen through fewer nodes: all of them in a box, and further apart the further away, with displacements
/// linear between (model/EQUATIONS.md, "Far field").

#include <array>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "model/dynamics/lattice.hpp"
#include "model/dynamics/problem.hpp"

namespace palpate {

/// Of nodes (i, j, l), both ends included.
struct LatticeBox {
  std::array<int, 3> first{};
  std::array<int, 3> last{};
  [[nodiscard]] bool holds(const std::array<int, 3>& place) const {
    for (std::size_t n = 0; n < 3; ++n) {
      if (place[n] < first[n] || place[n] > last[n]) { return false; }
    }
    return true;
  }
};

class GradedLattice {
 public:
  static constexpr int corners = 8;
  /// A node between the corners of a cell of coarse nodes.
  struct Place {
    std::array<Eigen::Index, corners> coordinate{};  ///< first ones; -1: held
    std::array<double, corners> weight{};            ///< sum to one, or all zero for a held node
  };

  /// `shape` is lattice_of() the problem's network.
  GradedLattice(const NetworkProblem& problem, const LatticeShape& shape, const LatticeBox& box);

  [[nodiscard]] Eigen::Index dof() const { return dof_; }
  /// Of a node of the box alone: its own first coordinate here, or -1.
  [[nodiscard]] Eigen::Index coordinate(int node) const;
  /// Of any node.
  [[nodiscard]] Place place_of(int node) const;
  /// Of each coarse coordinate, which carries its share of the nodes around [kg].
  [[nodiscard]] Eigen::VectorXd mass() const;

  class Statics {
   public:
    /// Throws std::invalid_argument where nothing holds the lattice.
    explicit Statics(const GradedLattice& lattice);
    /// Displacements X (a column for each load; coarse coordinates) that loads F bring about at rest, by K X = F with
    /// the springs linear about rest.
    [[nodiscard]] Eigen::MatrixXd respond(const Eigen::MatrixXd& loads) const { return factors_.solve(loads); }

   private:
    Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factors_;
  };

 private:
  using Axis = std::vector<int>;  ///< places of coarse nodes along it
  using Cell = std::array<int, 3>;
  static constexpr int block = 3 * corners;
  struct CellStiffness {
    std::array<Eigen::Index, corners> coordinate{};
    Eigen::Matrix<double, block, block> matrix = Eigen::Matrix<double, block, block>::Zero();  ///< its lower half [N/m]
  };
  [[nodiscard]] Eigen::Index index(int i, int j, int l) const;
  [[nodiscard]] Cell cell_from(const std::array<int, 3>& place) const;
  [[nodiscard]] Place place_in(int node, const Cell& cell) const;
  [[nodiscard]] std::vector<CellStiffness> cells_with_springs() const;
  [[nodiscard]] Eigen::SparseMatrix<double> stiffness() const;

  const NetworkProblem& problem_;
  LatticeShape shape_;
  std::array<Axis, 3> axes_{};
  std::array<std::vector<int>, 3> cell_of_{};  ///< that begins at or before a place along an axis
  std::vector<Eigen::Index> coordinate_{};     ///< of coarse nodes
  Eigen::Index dof_ = 0;
};

}  // namespace palpate
