// SPDX-License-Identifier: MIT
#pragma once
/// What tissue away from a tool, linear about rest and left with few shapes, does to the rest
/// (model/EQUATIONS.md, "Far field").

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

#include "model/kernels/list_network.hpp"
#include "model/kernels/system.hpp"
#include "model/problem/problem.hpp"
#include "model/reduction/mode_basis.hpp"

namespace palpate {

/// What a far field does to near nodes, and to itself. Coordinates of shapes follow those of near
/// nodes.
template <class Real> class ReducedModel {
 public:
  /// `near` is the problem without far nodes: there they are held.
  ReducedModel(const NetworkProblem& problem, const NetworkProblem& near, const ModeBasis& shapes);

  [[nodiscard]] Eigen::Index modes() const { return stiffness_.size(); }
  [[nodiscard]] const Eigen::VectorXd& mass() const { return mass_; }  ///< of the shapes [kg]
  void add(const Vector<Real>& q, const Vector<Real>& v, Vector<Real>& f) noexcept;
  void add_damping(const Vector<Real>& w, Vector<Real>& f) noexcept;  ///< adds C w
  [[nodiscard]] double energy(const Vector<Real>& q) noexcept;        ///< [J]
  void add_pattern(std::vector<Eigen::Triplet<Real>>& entries) const;
  /// After add_pattern(): where a matrix has the entries.
  void find_slots(const Eigen::SparseMatrix<Real>& a);
  void add_jacobian(Real on_damping, Real on_stiffness,
                    Eigen::SparseMatrix<Real>& a) const noexcept;
  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
  using Matrix3 = Eigen::Matrix<Real, 3, 3>;
  /// A near node with springs to far ones.
  struct Edge {
    Eigen::Index coordinate = 0;
    Eigen::Matrix<Real, 3, 1> rest{};
    Matrix3 stiffness{};        ///< of these springs [N/m]
    Real lag{};                 ///< their viscosity over their stiffness [s]
    std::ptrdiff_t slots[3]{};  ///< of the shapes in its columns
    std::ptrdiff_t diagonal_slots[3]{};
  };
  Eigen::Index first_ = 0;  ///< of the shapes' coordinates
  std::vector<Edge> edges_{};
  Matrix coupling_{};         ///< modes x 3 edges [N/m]
  Vector<Real> stiffness_{};  ///< of the shapes [N/m]
  Matrix damping_{};          ///< likewise [N s/m]
  Eigen::VectorXd mass_{};
  std::vector<std::ptrdiff_t>
      shape_slots_{};     ///< of the edges' coordinates in a shape's column, then of the shapes'
  Vector<Real> moved_{};  ///< of the edges
  Vector<Real> pulled_{};
};

// A lattice about a tool or a load as a list of springs, and what lies further away as a far field:
// the coordinates of the near nodes, then those of its shapes.

/// What is made before the network of it.
struct NearAndFar {
  NetworkProblem near;  ///< without far nodes: there they are held, and no spring leads to them
  ModeBasis shapes;
  /// Of a lattice at its natural lengths, at rest and without weight, loaded at near nodes alone.
  static NearAndFar of(const NetworkProblem& problem, const ReductionSetting& setting);
};

template <class Real> class ReducedNetwork final : private NearAndFar, public ListNetwork<Real> {
 public:
  ReducedNetwork(const NetworkProblem& problem, const ReductionSetting& setting);

  [[nodiscard]] bool has_dampers() const override { return true; }
  void damping(const Vector<Real>& q, const Vector<Real>& w, Vector<Real>& f) noexcept override;
  void jacobian(const Vector<Real>& q, const Vector<Real>& v, Real on_damping, Real on_stiffness,
                Eigen::SparseMatrix<Real>& a) noexcept override;
  void pattern(Eigen::SparseMatrix<Real>& a) override;
  [[nodiscard]] Eigen::Vector3d moved(const Vector<Real>& all, int node) const noexcept override;

 private:
  ReducedNetwork(const NetworkProblem& problem, NearAndFar parts);
  void add_springs(const Vector<Real>& q, const Vector<Real>& v, Vector<Real>& f) noexcept override;
  double measure_springs(const Vector<Real>& q, const Vector<Real>& v,
                         Vector<Real>& f) noexcept override;
  [[nodiscard]] double elastic_energy(const Vector<Real>& q) const noexcept override;
  [[nodiscard]] std::size_t spring_bytes() const noexcept override;
  void add_entries(std::vector<Eigen::Triplet<Real>>& entries) const override {
    far_.add_pattern(entries);
  }

  mutable ReducedModel<Real> far_;
};

}  // namespace palpate
