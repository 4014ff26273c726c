// SPDX-License-Identifier: MIT
#pragma once
/// A lattice about a tool or a load as a list of springs, and what lies further away as a far field: the coordinates of the near
/// nodes, then those of its shapes.

#include "model/stepping/far_field.hpp"
#include "model/stepping/list_network.hpp"

namespace palpate {

/// What is made before the network of it.
struct NearAndFar {
  NetworkProblem near;  ///< without far nodes: there they are held, and no spring leads to them
  FarShapes shapes;
  /// Of a lattice at its natural lengths, at rest and without weight, loaded at near nodes alone.
  static NearAndFar of(const NetworkProblem& problem, const FarFieldSetting& setting);
};

template <class Real>
class FarFieldNetwork final : private NearAndFar, public ListNetwork<Real> {
 public:
  FarFieldNetwork(const NetworkProblem& problem, const FarFieldSetting& setting);

  [[nodiscard]] bool has_dampers() const override { return true; }
  void damping(const Vector<Real>& q, const Vector<Real>& w, Vector<Real>& f) noexcept override;
  void jacobian(const Vector<Real>& q, const Vector<Real>& v, Real on_damping, Real on_stiffness,
                Eigen::SparseMatrix<Real>& a) noexcept override;
  void pattern(Eigen::SparseMatrix<Real>& a) override;
  [[nodiscard]] Eigen::Vector3d moved(const Vector<Real>& all, int node) const noexcept override;

 private:
  FarFieldNetwork(const NetworkProblem& problem, NearAndFar parts);
  void add_springs(const Vector<Real>& q, const Vector<Real>& v, Vector<Real>& f) noexcept override;
  double measure_springs(const Vector<Real>& q, const Vector<Real>& v, Vector<Real>& f) noexcept override;
  [[nodiscard]] double elastic_energy(const Vector<Real>& q) const noexcept override;
  [[nodiscard]] std::size_t spring_bytes() const noexcept override;
  void add_entries(std::vector<Eigen::Triplet<Real>>& entries) const override { far_.add_pattern(entries); }

  mutable FarField<Real> far_;
};

}  // namespace palpate
