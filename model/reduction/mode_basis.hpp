// SPDX-License-Identifier: MIT
#pragma once
/// Where a scene pushes its tissue, and which way.

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "model/problem/needle_path.hpp"
#include "model/problem/problem.hpp"
#include "model/problem/spring_network.hpp"

namespace palpate {

/// A force that a scene may put on its tissue.
struct LoadCase {
  std::vector<NeedlePath::Support> on{};  ///< free nodes, each with its part of the force
  Eigen::Vector3d direction{};            ///< of length 1
};

/// Along x, y and z at every knot of the scene's tool, and what its loads pull at; where no free
/// node is, there is none.
std::vector<LoadCase> load_cases_of(const Scene& scene, const NetworkProblem& problem);

/// Nodes that the scene's tool may push, fixed ones too; some several times.
std::vector<int> nodes_of_tool(const Scene& scene, const SpringNetwork& network);

// A lattice seen through fewer nodes: all of them in a box, and further apart the further away,
// with displacements linear between (model/EQUATIONS.md, "Far field").

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

  /// `shape` is the lattice of the problem's network.
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
    /// Displacements X (a column for each load; coarse coordinates) that loads F bring about at
    /// rest, by K X = F with the springs linear about rest.
    [[nodiscard]] Eigen::MatrixXd respond(const Eigen::MatrixXd& loads) const {
      return factors_.solve(loads);
    }

   private:
    Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factors_;
  };

 private:
  using Axis = std::vector<int>;  ///< places of coarse nodes along it
  using Cell = std::array<int, 3>;
  static constexpr int block = 3 * corners;
  struct CellStiffness {
    std::array<Eigen::Index, corners> coordinate{};
    Eigen::Matrix<double, block, block> matrix =
        Eigen::Matrix<double, block, block>::Zero();  ///< its lower half [N/m]
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

// Which nodes about a tool, or a load, are stepped as they are, while a far field stands for the
// others.

/// Of a lattice.
struct NearNodes {
  std::vector<unsigned char> near{};  ///< of each node: whether it is one
  LatticeBox box{};                   ///< around all that are
  [[nodiscard]] bool holds(int node) const { return near[static_cast<std::size_t>(node)] != 0; }
};

struct NearChoice {
  std::optional<NearNodes> nodes{};
  long far_nodes = 0;         ///< free ones
  const char* obstacle = "";  ///< why none is left to a far field
};

/// All nodes of a lattice within simulation.near_radius of those that the scene load_cases.
NearChoice choose_near_nodes(const Scene& scene, const NetworkProblem& problem);

// The few shapes in which tissue away from a tool is left to move (model/EQUATIONS.md, "Far
// field").

/// What is left to a far field: all but what is near to what is pushed.
struct ReductionSetting {
  NearNodes near{};
  std::vector<LoadCase> load_cases{};
  int modes = 0;  ///< at most
};

/// A far node moves by phi^T z, z the coordinates of the shapes: phi has 3 columns, of modes()
/// numbers each.
struct ModeBasis {
  std::vector<std::ptrdiff_t> column{};  ///< first of each node; -1: a near node, or a held one
  Eigen::MatrixXd phi{};                 ///< modes x 3 far nodes
  double mass = 0.0;                     ///< of each shape: that of a mean far node [kg]
  [[nodiscard]] Eigen::Index modes() const { return phi.rows(); }
  /// The columns of a node, or nothing that moves.
  [[nodiscard]] bool holds(int node) const { return column[static_cast<std::size_t>(node)] >= 0; }
  [[nodiscard]] auto of(int node) const {
    return phi.middleCols<3>(column[static_cast<std::size_t>(node)]);
  }
};

/// `shape` is the lattice of the problem's network.
ModeBasis mode_basis(const NetworkProblem& problem, const LatticeShape& shape,
                     const ReductionSetting& setting);

// Springs that move with the shapes of a far field, and sums over them.

/// Sums of k s s^T over many s, some at a time.
class GramSum {
 public:
  explicit GramSum(Eigen::Index size)
      : rows_(size, together), sum_(Eigen::MatrixXd::Zero(size, size)) {}
  template <class Row> void add(const Row& row, double factor) {
    rows_.col(count_++) = std::sqrt(factor) * row;
    if (count_ == rows_.cols()) { flush(); }
  }
  Eigen::MatrixXd take() {
    flush();
    return sum_.selfadjointView<Eigen::Lower>();
  }

 private:
  static constexpr Eigen::Index together = 512;
  void flush() {
    sum_.selfadjointView<Eigen::Lower>().rankUpdate(rows_.leftCols(count_));
    count_ = 0;
  }
  Eigen::MatrixXd rows_;
  Eigen::MatrixXd sum_;
  Eigen::Index count_ = 0;
};

/// visit(spring, u, s) for each spring that moves with the shapes: it grows by s^T z less u . x of
/// its near end, if it has one, u being its direction towards the far one.
template <class Visit>
void visit_far_springs(const SpringNetwork& network, const ModeBasis& shapes, Visit visit) {
  Eigen::VectorXd grows(shapes.modes());
  for (const Spring& spring : network.springs) {
    const bool from = shapes.holds(spring.a);
    const bool to = shapes.holds(spring.b);
    if (!from && !to) { continue; }
    Eigen::Vector3d u =
        (network.rest_position.col(spring.b) - network.rest_position.col(spring.a)).normalized();
    if (to) { grows.noalias() = shapes.of(spring.b) * u; }
    if (from && to) { grows.noalias() -= shapes.of(spring.a) * u; }
    if (from && !to) {
      u = -u;
      grows.noalias() = shapes.of(spring.a) * u;
    }
    visit(spring, u, grows);
  }
}

}  // namespace palpate
