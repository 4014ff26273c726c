// SPDX-License-Identifier: MIT
#pragma once
/// Tissue away from a tool, linear about rest and left with few shapes of its motion (model/EQUATIONS.md, "Far field").

#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "model/dynamics/needle_path.hpp"
#include "model/stepping/graded_lattice.hpp"
#include "model/stepping/system.hpp"

namespace palpate {

/// A far node moves by phi^T z, z the coordinates of the shapes: phi has 3 columns, of modes() numbers each.
struct FarShapes {
  std::vector<std::ptrdiff_t> column{};  ///< first of each node; -1: a near node, or a held one
  Eigen::MatrixXd phi{};                 ///< modes x 3 far nodes
  [[nodiscard]] Eigen::Index modes() const { return phi.rows(); }
  /// The columns of a node, or nothing that moves.
  [[nodiscard]] bool holds(int node) const { return column[static_cast<std::size_t>(node)] >= 0; }
  [[nodiscard]] auto of(int node) const { return phi.middleCols<3>(column[static_cast<std::size_t>(node)]); }
};

/// Responses at rest to what a tool may do: forces on each of its knots, and `modes` in all with random ones on the
/// nodes of the box (fewer shapes than forces on knots are random sums of those). Scaled so that all have the
/// mass of a mean node, and are modes of the far field alone.
FarShapes far_shapes(const NetworkProblem& problem, const LatticeShape& shape, const LatticeBox& box,
                     const NeedlePath& path, int modes);

/// What a far field does to near nodes, and to itself. Coordinates of shapes follow those of near nodes.
template <class Real>
class FarField {
 public:
  /// `near` is the problem without far nodes: there they are held.
  FarField(const NetworkProblem& problem, const NetworkProblem& near, const FarShapes& shapes);

  [[nodiscard]] Eigen::Index modes() const { return stiffness_.size(); }
  [[nodiscard]] const Eigen::VectorXd& mass() const { return mass_; }  ///< of the shapes [kg]
  void add(const Vector<Real>& q, const Vector<Real>& v, Vector<Real>& f) noexcept;
  void add_damping(const Vector<Real>& w, Vector<Real>& f) noexcept;  ///< adds -C w
  [[nodiscard]] double energy(const Vector<Real>& q) noexcept;        ///< [J]
  void add_pattern(std::vector<Eigen::Triplet<Real>>& entries) const;
  /// After add_pattern(): where a matrix has the entries.
  void find_slots(const Eigen::SparseMatrix<Real>& a);
  void add_jacobian(Real on_damping, Real on_stiffness, Eigen::SparseMatrix<Real>& a) const noexcept;
  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
  using Matrix3 = Eigen::Matrix<Real, 3, 3>;
  /// A near node with springs to far ones.
  struct Edge {
    Eigen::Index coordinate = 0;
    Eigen::Matrix<Real, 3, 1> rest{};
    Matrix3 stiffness{};  ///< of these springs [N/m]
    Real lag{};           ///< their viscosity over their stiffness [s]
    std::ptrdiff_t slots[3]{};         ///< of the shapes in its columns
    std::ptrdiff_t diagonal_slots[3]{};
  };
  void gather(const Vector<Real>& all, bool from_rest) noexcept;

  Eigen::Index first_ = 0;             ///< of the shapes' coordinates
  std::vector<Edge> edges_{};
  Matrix coupling_{};                  ///< modes x 3 edges [N/m]
  Vector<Real> stiffness_{};           ///< of the shapes [N/m]
  Matrix damping_{};                   ///< likewise [N s/m]
  Eigen::VectorXd mass_{};
  std::vector<std::ptrdiff_t> shape_slots_{};  ///< of the edges' coordinates in a shape's column, then of the shapes'
  Vector<Real> moved_{};               ///< of the edges
  Vector<Real> pulled_{};
};

}  // namespace palpate
