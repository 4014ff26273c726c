// SPDX-License-Identifier: MIT
#pragma once
/// A regular lattice under an explicit scheme: no index arrays, one pass over memory, explicit SIMD
/// (model/EQUATIONS.md, "Lattice in lanes"). Fixed nodes and the elements that fill rows up have no
/// inverse mass and never move.

#include <optional>
#include <span>

#include "model/stepping/lattice_sleep.hpp"
#include "model/stepping/lattice_slabs.hpp"
#include "model/stepping/lattice_springs.hpp"
#include "model/stepping/network_system.hpp"

namespace palpate {

template <class Real>
class LatticeNetwork final : public NetworkSystem<Real> {
 public:
  /// Throws std::invalid_argument for a network that lattice_of() does not know. `may_fold`: see LatticeRows.
  LatticeNetwork(const NetworkProblem& problem, bool skip, int threads = 1,
                 const lattice::Kernels<Real>& kernels = lattice_kernels<Real>().front(), bool may_fold = true);

  /// Rows that nothing displaces, moves or loads in the beginning sleep, but those of `touched` nodes
  /// (lattice_sleep.hpp). For one thread, without weight and without folds.
  void let_sleep(double most_withheld, std::span<const int> touched = {});
  [[nodiscard]] double awake_share() const noexcept override { return sleep_ ? sleep_->awake_share() : 1.0; }

  void damping(const Vector<Real>& q, const Vector<Real>& w, Vector<Real>& f) noexcept override;
  [[nodiscard]] bool has_dampers() const override { return damped_; }
  [[nodiscard]] bool has_one_pass() const override { return true; }
  void prepare_one_pass() override;
  double one_pass(double t, double gate, Real h, State<Real>& state) noexcept override;
  [[nodiscard]] Vector<Real> initial_position() const override { return springs_.initial_position(); }

 private:
  LatticeNetwork(const NetworkProblem& problem, LatticeSprings<Real> springs,
                 const lattice::Kernels<Real>& kernels, bool skip, int threads);
  void add_springs(const Vector<Real>& q, const Vector<Real>& v, Vector<Real>& f) noexcept override;
  double measure_springs(const Vector<Real>& q, const Vector<Real>& v, Vector<Real>& f) noexcept override;
  [[nodiscard]] double elastic_energy(const Vector<Real>& q) const noexcept override;
  [[nodiscard]] std::size_t spring_bytes() const noexcept override;

  double one_pass_with_sleep(double t, double gate, Real h, State<Real>& state) noexcept;
  void sort_loads();

  LatticeSprings<Real> springs_;
  bool damped_;
  lattice::Kernels<Real> kernels_;
  lattice::Kernel<Real> force_ = nullptr;
  lattice::Kernel<Real> step_ = nullptr;
  std::optional<LatticeSleep<Real>> sleep_;  ///< where rows may sleep
  std::unique_ptr<LatticeSlabs<Real>> slabs_;
  Vector<Real> next_force_;  ///< between two steps in one pass, where rows may sleep [N]
  std::vector<typename NetworkSystem<Real>::LoadOnCoordinate> loaded_;  ///< by layers, for steps in one pass
  std::vector<Pull<Real>> pulls_;
  std::vector<int> pulls_begin_;
};

}  // namespace palpate
