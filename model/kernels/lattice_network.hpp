// SPDX-License-Identifier: MIT
#pragma once
/// Regular lattice in SIMD lanes, on one thread or several.

#include <memory>
#include <span>

#include "model/kernels/kernel_views.hpp"
#include "model/kernels/lattice_springs.hpp"
#include "model/kernels/network_system.hpp"
#include "model/kernels/system.hpp"

namespace palpate {

template <class Real> class LatticeSlabs;
template <class Real> class LatticeSleep;

/// Returns the largest useful number of threads, at most `wanted`: two layers or more for each.
/// Rows of one vector are not partitioned, because vectors at the ends of such a row access rows of
/// other layers.
int most_lattice_threads(int layers, long vectors, int wanted);

// Regular lattice for explicit schemes: no index arrays, one pass over memory, explicit SIMD
// (model/EQUATIONS.md, "Lattice in lanes"). Fixed nodes and padding elements have zero inverse mass
// and never move.

template <class Real> class LatticeNetwork final : public NetworkSystem<Real> {
 public:
  /// Builds the lattice. Throws std::invalid_argument if the network is not a regular lattice.
  /// `may_fold`: see LatticeRows.
  LatticeNetwork(const NetworkProblem& problem, bool skip, int threads = 1,
                 const lattice::Kernels<Real>& kernels = lattice_kernels<Real>().front(),
                 bool may_fold = true);
  ~LatticeNetwork() override;

  /// Enables sleeping rows. Rows without initial displacement, velocity or load sleep, except the
  /// rows of `touched` nodes. Requires one thread, no weight and no folded
  /// rows.
  void let_sleep(double most_withheld, std::span<const int> touched = {});
  [[nodiscard]] double awake_share() const noexcept override;

  void damping(const Vector<Real>& q, const Vector<Real>& w, Vector<Real>& f) noexcept override;
  [[nodiscard]] bool has_dampers() const override { return damped_; }
  [[nodiscard]] bool has_one_pass() const override { return true; }
  void prepare_one_pass() override;
  double one_pass(double t, double gate, Real h, State<Real>& state) noexcept override;
  [[nodiscard]] Vector<Real> initial_position() const override {
    return springs_.initial_position();
  }

 private:
  LatticeNetwork(const NetworkProblem& problem, LatticeSprings<Real> springs,
                 const lattice::Kernels<Real>& kernels, bool skip, int threads);
  void add_springs(const Vector<Real>& q, const Vector<Real>& v, Vector<Real>& f) noexcept override;
  double measure_springs(const Vector<Real>& q, const Vector<Real>& v,
                         Vector<Real>& f) noexcept override;
  [[nodiscard]] double elastic_energy(const Vector<Real>& q) const noexcept override;
  [[nodiscard]] std::size_t spring_bytes() const noexcept override;

  LatticeSprings<Real> springs_;
  bool damped_;
  lattice::Kernels<Real> kernels_;
  lattice::Kernel<Real> force_ = nullptr;
  lattice::Kernel<Real> step_ = nullptr;
  std::unique_ptr<LatticeSleep<Real>> sleep_;  ///< null if no row may sleep
  std::unique_ptr<LatticeSlabs<Real>> slabs_;
  /// Force between two one-pass steps: the weight, and the withheld forces of sleeping rows [N].
  Vector<Real> next_force_;
};

}  // namespace palpate
