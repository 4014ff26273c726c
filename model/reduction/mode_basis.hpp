// SPDX-License-Identifier: MIT
#pragma once
/// Load cases of a scene, the choice of near nodes, and the modes that represent the far nodes.

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "model/problem/needle_path.hpp"
#include "model/problem/problem.hpp"
#include "model/problem/spring_network.hpp"

namespace palpate {

/// Number of free nodes up to which the stiffness matrix of every node is factorised.
inline constexpr std::size_t most_factorised_nodes = 5000;

/// Force of unit magnitude that a scene can apply to its tissue.
struct LoadCase {
  std::vector<NeedlePath::Support> on{};  ///< free nodes, each with its share of the force
  Eigen::Vector3d direction{};            ///< unit vector
};

/// Returns the load cases at the free contact points that the scene's tool can reach, along x, y
/// and z, and at the loaded free nodes. The depth of a trajectory ends its reach.
std::vector<LoadCase> load_cases_of(const Scene& scene, const NetworkProblem& problem);

/// Returns the nodes that the scene's tool can load, fixed ones too, some several times.
std::vector<int> nodes_of_tool(const Scene& scene, const SpringNetwork& network);

// Coarse model of a lattice: all nodes inside a box, or every second or third of a large one, and
// a spacing that grows with the distance from it. Displacements are interpolated linearly between
// coarse nodes (model/EQUATIONS.md, "Far field").

/// Box of lattice nodes (i, j, l), both ends included.
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
  /// Position of a lattice node in a cell of coarse nodes, for trilinear interpolation.
  struct Place {
    std::array<Eigen::Index, corners> coordinate{};  ///< first coordinate of each corner; -1: fixed
    std::array<double, corners> weight{};            ///< sum to one, or all zero for a fixed node
  };

  /// Builds the coarse model. `shape` is the lattice of the problem's network.
  GradedLattice(const NetworkProblem& problem, const LatticeShape& shape, const LatticeBox& box);

  [[nodiscard]] Eigen::Index dof() const { return dof_; }
  /// Returns the interpolation of any lattice node.
  [[nodiscard]] Place place_of(int node) const;
  /// Returns the mass per coarse coordinate, lumped from the nodes around it [kg].
  [[nodiscard]] Eigen::VectorXd mass() const;

  /// Returns the lower half of the stiffness matrix, linear about rest [N/m].
  [[nodiscard]] Eigen::SparseMatrix<double> stiffness() const;
  [[nodiscard]] NodeVectors places() const;  ///< of the coarse nodes, in nodes of the lattice

 private:
  using Axis = std::vector<int>;  ///< positions of the coarse nodes along one axis
  using Cell = std::array<int, 3>;
  static constexpr int block = 3 * corners;
  struct CellStiffness {
    std::array<Eigen::Index, corners> coordinate{};
    using Matrix = Eigen::Matrix<double, block, block>;
    Matrix matrix = Matrix::Zero();  ///< lower half of the element stiffness [N/m]
  };
  [[nodiscard]] Eigen::Index index(int i, int j, int l) const;
  [[nodiscard]] Cell cell_from(const std::array<int, 3>& place) const;
  [[nodiscard]] Place place_in(int node, const Cell& cell) const;
  [[nodiscard]] std::vector<CellStiffness> element_stiffness() const;
  void add_volumes(std::vector<CellStiffness>& cells) const;
  [[nodiscard]] std::size_t number_of(const Cell& cell) const;

  const NetworkProblem& problem_;
  LatticeShape shape_;
  std::array<Axis, 3> axes_{};
  /// Index of the last cell that begins at or before a position, per axis.
  std::array<std::vector<int>, 3> cell_of_{};
  std::vector<Eigen::Index> coordinate_{};  ///< first coordinate of each coarse node
  Eigen::Index dof_ = 0;
};

/// All nodes of a network in place of a coarse model; the members are those of GradedLattice.
class EveryNode {
 public:
  struct Place {
    std::array<Eigen::Index, 1> coordinate{};
    std::array<double, 1> weight{};
  };

  explicit EveryNode(const NetworkProblem& problem) : problem_(problem) {}
  [[nodiscard]] Eigen::Index dof() const { return problem_.dof(); }
  [[nodiscard]] Place place_of(int node) const {
    const Eigen::Index at = problem_.coordinate(node);
    return {{at}, {at < 0 ? 0.0 : 1.0}};
  }
  [[nodiscard]] const Eigen::VectorXd& mass() const { return problem_.mass(); }
  [[nodiscard]] Eigen::SparseMatrix<double> stiffness() const;
  [[nodiscard]] NodeVectors places() const;  ///< of the free nodes at rest [m]

 private:
  const NetworkProblem& problem_;
};

/// Static displacements X from K X = F, one column per load. K is factorised in the order of a
/// nested dissection of its nodes in space (A. George, SIAM J. Numer. Anal. 10, 345, 1973), which
/// leaves fewer entries in the factors of a block than an ordering by degree.
class StaticSolver {
 public:
  /// Factorises K, given by its lower half. Rows 3 n to 3 n + 2 belong to the node at column n of
  /// `place`, in any unit of length.
  StaticSolver(const Eigen::SparseMatrix<double>& stiffness, const NodeVectors& place);
  /// Returns false if the tissue can move without a force: then there is no response.
  [[nodiscard]] bool held() const { return held_; }
  [[nodiscard]] Eigen::MatrixXd respond(const Eigen::MatrixXd& loads) const {
    return order_.transpose() * factors_.solve(order_ * loads);
  }

 private:
  Eigen::PermutationMatrix<Eigen::Dynamic> order_;  ///< from rows of K to those of the factors
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::NaturalOrdering<int>>
      factors_;
  bool held_ = false;
};

/// Set of nodes that are integrated in full; the rest is represented by the reduced-order model.
struct NearNodes {
  std::vector<unsigned char> near{};  ///< 1 for each near node
  LatticeBox box{};                   ///< bounding box of the near nodes of a regular lattice
  [[nodiscard]] bool holds(int node) const { return near[static_cast<std::size_t>(node)] != 0; }
};

struct NearChoice {
  std::optional<NearNodes> nodes{};
  long far_nodes = 0;         ///< number of free far nodes
  const char* obstacle = "";  ///< reason why no reduced-order model is possible
};

/// Returns all nodes within simulation.near_radius of the nodes that the scene loads.
NearChoice choose_near_nodes(const Scene& scene, const NetworkProblem& problem);

/// Settings of the reduced-order model (model/EQUATIONS.md, "Far field").
struct ReductionSetting {
  NearNodes near{};
  std::vector<LoadCase> load_cases{};
  int modes = 0;  ///< upper limit
};

/// Mode basis. A far node moves by phi^T z, where z are the modal coordinates; phi has three
/// columns of modes() entries per far node.
struct ModeBasis {
  std::vector<std::ptrdiff_t> column{};  ///< first column of each node; -1: near or fixed node
  Eigen::MatrixXd phi{};                 ///< modes x 3 far nodes
  double mass = 0.0;  ///< mass of each mode, equal to the mean mass of a far node [kg]
  [[nodiscard]] Eigen::Index modes() const { return phi.rows(); }
  /// Returns true if the node is a far node.
  [[nodiscard]] bool holds(int node) const { return column[static_cast<std::size_t>(node)] >= 0; }
  [[nodiscard]] auto of(int node) const {
    return phi.middleCols<3>(column[static_cast<std::size_t>(node)]);
  }
};

ModeBasis mode_basis(const NetworkProblem& problem, const ReductionSetting& setting);

// Springs and cells with at least one far node, and sums over them.

/// Sum of k s s^T over many vectors s, accumulated in blocks.
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

/// Returns the derivatives of a cell's relative volume J by the places of its corners, at rest
/// [1/m].
std::array<Eigen::Vector3d, 8> volume_gradient(const SpringNetwork& network,
                                               const VolumeCell& cell);

/// Part of the energy about rest that depends on far nodes, k/2 e^2. For a spring, e is its
/// elongation [m] and k its stiffness [N/m]. For a cell that resists changes of its volume, e is
/// J - 1 and k = kappa V0 [N m]. With the displacements x of its near nodes, e = s . z + sum of g .
/// x.
struct FarPart {
  double stiffness = 0.0;
  double viscosity = 0.0;
  int near_count = 0;
  std::array<std::pair<int, Eigen::Vector3d>, 8> near{};  ///< nodes that are not far, with g
  Eigen::VectorXd grows{};                                ///< s

  void add(const ModeBasis& shapes, int node, const Eigen::Vector3d& gradient) {
    if (shapes.holds(node)) {
      grows.noalias() += shapes.of(node) * gradient;
    } else {
      near[static_cast<std::size_t>(near_count++)] = {node, gradient};
    }
  }
};

/// Calls visit(part) for each spring and cell with a far node.
template <class Visit>
void visit_far_parts(const SpringNetwork& network, const ModeBasis& shapes, Visit visit) {
  FarPart part;
  const auto begin = [&](double stiffness, double viscosity) {
    part.stiffness = stiffness;
    part.viscosity = viscosity;
    part.near_count = 0;
    part.grows.setZero(shapes.modes());
  };
  for (const Spring& spring : network.springs) {
    if (!shapes.holds(spring.a) && !shapes.holds(spring.b)) { continue; }
    const Eigen::Vector3d u =
        (network.rest_position.col(spring.b) - network.rest_position.col(spring.a)).normalized();
    begin(spring.stiffness, spring.viscosity);
    part.add(shapes, spring.b, u);
    part.add(shapes, spring.a, -u);
    visit(std::as_const(part));
  }
  for (const VolumeCell& cell : network.cells) {
    const auto far = [&](int node) { return shapes.holds(node); };
    if (cell.stiffness == 0.0 || std::ranges::none_of(cell.nodes, far)) { continue; }
    begin(cell.stiffness * cell.volume, cell.viscosity * cell.volume);
    const std::array<Eigen::Vector3d, 8> gradient = volume_gradient(network, cell);
    for (std::size_t n = 0; n < 8; ++n) { part.add(shapes, cell.nodes[n], gradient[n]); }
    visit(std::as_const(part));
  }
}

}  // namespace palpate
