// SPDX-License-Identifier: MIT
#pragma once
/// Load cases of a scene, the choice of near nodes, and the modes that represent the far nodes.

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
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
/// and z, and at the loaded free nodes. The depth of a trajectory, with one contact point more than
/// it needs, ends its reach.
std::vector<LoadCase> load_cases_of(const Scene& scene, const NetworkProblem& problem);

/// Returns the nodes that the scene's tool can load, fixed ones too, some several times.
std::vector<int> nodes_of_tool(const Scene& scene, const SpringNetwork& network);

/// Selects the stiffness or the viscosity of springs and cells.
enum class Constant { stiffness, viscosity };

/// 1 for each far node, 0 for each near or fixed one.
using FarNodes = std::vector<unsigned char>;

/// Points whose displacements give those of all nodes of a network. Coordinates are three for each
/// free point. Matrices are given by their lower halves.
class PointModel {
 public:
  static constexpr int corners = 8;
  /// Points around a node, with weights that sum to one, or are all zero for a fixed node.
  struct Place {
    std::array<Eigen::Index, corners> coordinate{};  ///< first coordinate of each point; -1: fixed
    std::array<double, corners> weight{};
  };

  /// The problem must outlive the model.
  explicit PointModel(const NetworkProblem& problem) : problem_(problem) {}
  PointModel(const PointModel&) = delete;
  PointModel& operator=(const PointModel&) = delete;
  virtual ~PointModel() = default;

  [[nodiscard]] virtual Eigen::Index dof() const = 0;
  [[nodiscard]] virtual Place place_of(int node) const = 0;
  [[nodiscard]] virtual NodeVectors places() const = 0;  ///< of the free points, in any unit
  /// Returns the lumped mass per coordinate [kg].
  [[nodiscard]] virtual Eigen::VectorXd mass() const = 0;
  /// Returns the stiffness, linear about rest [N/m].
  [[nodiscard]] virtual Eigen::SparseMatrix<double> stiffness() const = 0;
  /// Returns the stiffness [N/m] or damping [N s/m] of the springs and cells that join far nodes
  /// with far or fixed nodes only, linear about rest.
  [[nodiscard]] virtual Eigen::SparseMatrix<double> far_part(const FarNodes& far,
                                                             Constant which) const = 0;
  /// Returns the mass of the far nodes [kg], with the mass between points.
  [[nodiscard]] virtual Eigen::SparseMatrix<double> far_mass(const FarNodes& far) const = 0;
  /// Returns the value at a node, interpolated between of_point(first coordinate of a point); fixed
  /// points have the value `zero`.
  template <class Value, class OfPoint>
  [[nodiscard]] Value interpolate(int node, Value zero, OfPoint of_point) const {
    const Place place = place_of(node);
    for (std::size_t c = 0; c < place.weight.size(); ++c) {
      if (place.coordinate[c] < 0 || place.weight[c] == 0.0) { continue; }
      zero += place.weight[c] * of_point(place.coordinate[c]);
    }
    return zero;
  }

 protected:
  const NetworkProblem& problem_;
};

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

/// Some nodes of a lattice: all inside a box, or every second or third of a large one, and a
/// spacing that grows with the distance from it. Displacements are interpolated linearly between
/// them (model/EQUATIONS.md, "Far field").
class GradedLattice final : public PointModel {
 public:
  /// `shape` is the lattice of the problem's network.
  GradedLattice(const NetworkProblem& problem, const LatticeShape& shape, const LatticeBox& box);

  [[nodiscard]] Eigen::Index dof() const override { return dof_; }
  [[nodiscard]] Place place_of(int node) const override;
  [[nodiscard]] NodeVectors places() const override;
  [[nodiscard]] Eigen::VectorXd mass() const override;
  /// A coarse cell has one mean volume: the volumes of all cells in it would lock it.
  [[nodiscard]] Eigen::SparseMatrix<double> stiffness() const override;
  [[nodiscard]] Eigen::SparseMatrix<double> far_part(const FarNodes& far,
                                                     Constant which) const override;
  [[nodiscard]] Eigen::SparseMatrix<double> far_mass(const FarNodes& far) const override;

 private:
  using Axis = std::vector<int>;  ///< positions of the coarse nodes along one axis
  using Cell = std::array<int, 3>;
  static constexpr int block = 3 * corners;
  using Growth = Eigen::Matrix<double, block, 1>;
  struct CellMatrix {
    std::array<Eigen::Index, corners> coordinate{};
    using Matrix = Eigen::Matrix<double, block, block>;
    Matrix matrix = Matrix::Zero();  ///< lower half
  };
  [[nodiscard]] Eigen::Index index(int i, int j, int l) const;
  [[nodiscard]] Cell cell_from(const std::array<int, 3>& place) const;
  [[nodiscard]] Place place_in(int node, const Cell& cell) const;
  [[nodiscard]] std::size_t number_of(const Cell& cell) const;
  [[nodiscard]] std::vector<CellMatrix> zero_cells() const;
  /// Returns the growth of a fine cell's relative volume by displacements of the corners of the
  /// coarse cell around it [1/m].
  [[nodiscard]] Growth growth_of(const VolumeCell& fine, const Cell& cell) const;
  /// Returns the cells with the sum of factor(spring) g g^T of the springs in them, g being the
  /// growth of a spring by the displacements of the corners.
  template <class Factor> [[nodiscard]] std::vector<CellMatrix> of_springs(Factor factor) const;
  void add_mean_volumes(std::vector<CellMatrix>& cells) const;
  [[nodiscard]] Eigen::SparseMatrix<double> assembled(const std::vector<CellMatrix>& cells) const;

  LatticeShape shape_;
  std::array<Axis, 3> axes_{};
  /// Index of the last cell that begins at or before a position, per axis.
  std::array<std::vector<int>, 3> cell_of_{};
  std::vector<Eigen::Index> coordinate_{};  ///< first coordinate of each coarse node
  Eigen::Index dof_ = 0;
};

/// All nodes of a network. The coordinates are those of the problem.
class EveryNode final : public PointModel {
 public:
  using PointModel::PointModel;
  [[nodiscard]] Eigen::Index dof() const override { return problem_.dof(); }
  [[nodiscard]] Place place_of(int node) const override {
    Place at;
    at.coordinate.fill(-1);
    at.coordinate[0] = problem_.coordinate(node);
    at.weight[0] = at.coordinate[0] < 0 ? 0.0 : 1.0;
    return at;
  }
  [[nodiscard]] NodeVectors places() const override;
  [[nodiscard]] Eigen::VectorXd mass() const override { return problem_.mass(); }
  [[nodiscard]] Eigen::SparseMatrix<double> stiffness() const override;
  [[nodiscard]] Eigen::SparseMatrix<double> far_part(const FarNodes& far,
                                                     Constant which) const override;
  [[nodiscard]] Eigen::SparseMatrix<double> far_mass(const FarNodes& far) const override;

 private:
  template <class Factor> [[nodiscard]] Eigen::SparseMatrix<double> sum_of(Factor factor) const;
};

/// Static displacements X from K X = F, one column per load. K is factorised in the order of
/// nested_dissection().
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

/// Returns the free nodes that are not near.
FarNodes far_nodes(const NetworkProblem& problem, const NearNodes& near);

struct NearChoice {
  std::optional<NearNodes> nodes{};
  long far_nodes = 0;         ///< number of free far nodes
  const char* obstacle = "";  ///< reason why no reduced-order model is possible
};

/// Returns all nodes within `radius` [m] of the nodes that the scene loads.
NearChoice choose_near_nodes(const Scene& scene, const NetworkProblem& problem, double radius);

/// Settings of the reduced-order model (model/EQUATIONS.md, "Far field").
struct ReductionSetting {
  double radius = 0.0;  ///< of the near nodes around the loaded ones [m]
  NearNodes near{};
  std::vector<LoadCase> load_cases{};
  int modes = 0;  ///< upper limit
};

/// Mode basis. A far node moves by phi^T z, where z are the modal coordinates and phi is
/// interpolated between points.
struct ModeBasis {
  std::unique_ptr<const PointModel> points{};
  FarNodes far{};
  Eigen::MatrixXd phi{};        ///< modes x coordinates of the points
  double mass = 0.0;            ///< mass of each mode, equal to the mean mass of a far node [kg]
  Eigen::VectorXd stiffness{};  ///< of each mode with all other nodes at rest [N/m]
  /// Damping by springs and cells that join far nodes with far or fixed nodes only [N s/m].
  Eigen::MatrixXd damping{};
  [[nodiscard]] Eigen::Index modes() const { return phi.rows(); }
  /// Returns true if the node is a far node.
  [[nodiscard]] bool holds(int node) const { return far[static_cast<std::size_t>(node)] != 0; }
  /// Returns the three columns of phi of a far node.
  [[nodiscard]] Eigen::Matrix<double, Eigen::Dynamic, 3> of(int node) const;
};

/// Builds the basis. The problem must outlive it.
ModeBasis mode_basis(const NetworkProblem& problem, const ReductionSetting& setting);

/// Returns the derivatives of a cell's relative volume J by the places of its corners, at rest
/// [1/m].
std::array<Eigen::Vector3d, 8> volume_gradient(const SpringNetwork& network,
                                               const VolumeCell& cell);

/// Spring or cell with far nodes and free near nodes: its part of the energy about rest, k/2 e^2.
/// For a spring, e is its elongation [m] and k its stiffness [N/m]. For a cell that resists changes
/// of its volume, e is J - 1 and k = kappa V0 [N m]. With the displacements x of its near nodes,
/// e = s . z + sum of g . x.
struct MixedPart {
  double stiffness = 0.0;
  double viscosity = 0.0;
  int near_count = 0;
  std::array<std::pair<int, Eigen::Vector3d>, 8> near{};  ///< free near nodes, with g
  Eigen::VectorXd grows{};                                ///< s
};

/// Calls visit(part) for each spring and cell with far nodes and free near nodes.
template <class Visit>
void visit_mixed_parts(const SpringNetwork& network, const ModeBasis& shapes, Visit visit) {
  MixedPart part;
  const auto is_near = [&](int node) { return !shapes.holds(node) && !network.is_fixed(node); };
  const auto is_far = [&](int node) { return shapes.holds(node); };
  const auto add = [&](int node, const Eigen::Vector3d& gradient) {
    if (is_far(node)) {
      part.grows.noalias() += shapes.of(node) * gradient;
    } else if (is_near(node)) {
      part.near[static_cast<std::size_t>(part.near_count++)] = {node, gradient};
    }
  };
  const auto begin = [&](double stiffness, double viscosity) {
    part.stiffness = stiffness;
    part.viscosity = viscosity;
    part.near_count = 0;
    part.grows.setZero(shapes.modes());
  };
  for (const Spring& spring : network.springs) {
    const bool mixed =
        (is_far(spring.a) && is_near(spring.b)) || (is_near(spring.a) && is_far(spring.b));
    if (!mixed) { continue; }
    const Eigen::Vector3d u =
        (network.rest_position.col(spring.b) - network.rest_position.col(spring.a)).normalized();
    begin(spring.stiffness, spring.viscosity);
    add(spring.b, u);
    add(spring.a, -u);
    visit(std::as_const(part));
  }
  for (const VolumeCell& cell : network.cells) {
    if (cell.stiffness == 0.0 || std::ranges::none_of(cell.nodes, is_far) ||
        std::ranges::none_of(cell.nodes, is_near)) {
      continue;
    }
    begin(cell.stiffness * cell.volume, cell.viscosity * cell.volume);
    const std::array<Eigen::Vector3d, 8> gradient = volume_gradient(network, cell);
    for (std::size_t n = 0; n < 8; ++n) { add(cell.nodes[n], gradient[n]); }
    visit(std::as_const(part));
  }
}

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

}  // namespace palpate
