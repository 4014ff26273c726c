// SPDX-License-Identifier: MIT
#pragma once
/// A regular lattice under an explicit scheme: no index arrays, one pass over memory, explicit SIMD
/// (model/EQUATIONS.md, "Lattice in lanes"). Fixed nodes and the elements that fill rows up have no
/// inverse mass and never move.

#include "model/stepping/lattice_springs.hpp"
#include "model/stepping/network_system.hpp"

namespace palpate {

template <class Real>
class LatticeNetwork final : public NetworkSystem<Real> {
 public:
  /// Throws std::invalid_argument for a network that lattice_of() does not know.
  LatticeNetwork(const NetworkProblem& problem, bool skip,
                 const lattice::Kernels<Real>& kernels = lattice_kernels<Real>());

  void damping(const Vector<Real>& q, const Vector<Real>& w, Vector<Real>& f) noexcept override;
  [[nodiscard]] Vector<Real> initial_position() const override { return springs_.initial_position(); }

 private:
  LatticeNetwork(const NetworkProblem& problem, LatticeSprings<Real> springs,
                 const lattice::Kernels<Real>& kernels, bool skip);
  void add_springs(const Vector<Real>& q, const Vector<Real>& v, Vector<Real>& f) noexcept override;
  double measure_springs(const Vector<Real>& q, const Vector<Real>& v, Vector<Real>& f) noexcept override;
  [[nodiscard]] double elastic_energy(const Vector<Real>& q) const noexcept override;
  [[nodiscard]] std::size_t spring_bytes() const noexcept override { return springs_.memory_bytes(); }

  LatticeSprings<Real> springs_;
  lattice::View<Real> view_;
  lattice::Kernels<Real> kernels_;
  lattice::Kernel<Real> force_;
  lattice::Kernel<Real> measure_;  ///< force_ that returns the energy too
};

}  // namespace palpate
