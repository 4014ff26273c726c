// SPDX-License-Identifier: MIT
#pragma once
/// Reduced-order model of the tissue far from a tool, linear about the rest state
/// (model/EQUATIONS.md, "Far field").

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

#include "model/kernels/list_network.hpp"
#include "model/kernels/system.hpp"
#include "model/problem/problem.hpp"
#include "model/reduction/mode_basis.hpp"

namespace palpate {

/// Forces of the reduced-order model on the near nodes and on its own modal coordinates, which
/// follow the coordinates of the near nodes.
template <class Real> class ReducedModel {
 public:
  /// Builds the model. `near` is the problem with all far nodes fixed.
  ReducedModel(const NetworkProblem& problem, const NetworkProblem& near, const ModeBasis& shapes);

  [[nodiscard]] Eigen::Index modes() const { return stiffness_.size(); }
  [[nodiscard]] const Eigen::VectorXd& mass() const { return mass_; }  ///< of the modes [kg]
  void add(const Vector<Real>& q, const Vector<Real>& v, Vector<Real>& f) noexcept;
  void add_damping(const Vector<Real>& w, Vector<Real>& f) noexcept;  ///< adds C w to f
  [[nodiscard]] double energy(const Vector<Real>& q) noexcept;        ///< [J]
  void add_pattern(std::vector<Eigen::Triplet<Real>>& entries) const;
  /// Finds the entries of matrix `a` that add_jacobian() changes; call it after add_pattern().
  void find_slots(const Eigen::SparseMatrix<Real>& a);
  void add_jacobian(Real on_damping, Real on_stiffness,
                    Eigen::SparseMatrix<Real>& a) const noexcept;
  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
  using Matrix3 = Eigen::Matrix<Real, 3, 3>;
  /// Near node with springs to far nodes.
  struct Edge {
    Eigen::Index coordinate = 0;
    Eigen::Matrix<Real, 3, 1> rest{};
    Matrix3 stiffness{};        ///< sum over these springs [N/m]
    Real lag{};                 ///< ratio of their viscosity to their stiffness [s]
    std::ptrdiff_t slots[3]{};  ///< first row of the modes in its three columns
    std::ptrdiff_t diagonal_slots[3]{};
  };
  Eigen::Index first_ = 0;  ///< first modal coordinate
  std::vector<Edge> edges_{};
  Matrix coupling_{};         ///< modes x 3 edges [N/m]
  Vector<Real> stiffness_{};  ///< of the modes [N/m]
  Matrix damping_{};          ///< of the modes [N s/m]
  Eigen::VectorXd mass_{};
  std::vector<std::ptrdiff_t>
      shape_slots_{};     ///< entries of the edges in a mode's column, then of the modes
  Vector<Real> moved_{};  ///< displacements of the edges
  Vector<Real> pulled_{};
};

// List of springs for the near nodes of a lattice plus a reduced-order model of the far nodes. The
// coordinates of the near nodes come first, then the modal coordinates.

/// Inputs of the network: the problem of the near nodes and the reduced-order model.
struct NearAndFar {
  NetworkProblem near;  ///< problem with the far nodes fixed and without their springs
  ModeBasis shapes;
  /// Builds both. The lattice must be at rest at its natural lengths, without weight, and loaded at
  /// near nodes only.
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
