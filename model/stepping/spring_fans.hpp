// SPDX-License-Identifier: MIT
#pragma once
/// The springs of a list, gathered by nodes, so that as many as a register holds are computed at once. Equals
/// spring_kernel_for() of the physical law to rounding.

#include <span>
#include <vector>

#include "model/stepping/aligned_vector.hpp"
#include "model/stepping/spring_fans_view.hpp"
#include "model/stepping/spring_kernels.hpp"

namespace palpate {

/// All that this processor can run, the best first.
template <class Real>
std::vector<fans::Kernels<Real>> fan_kernels();

template <class Real>
class SpringFans {
 public:
  explicit SpringFans(const fans::Kernels<Real>& kernels = fan_kernels<Real>().front()) : kernels_(kernels) {}
  /// Links and anchors; without their dampers unless `damped`. Vectors have `spacing` numbers for each node: fans::quad
  /// with places that never move behind the free nodes, read and written as they lie; or 3 and no such places, copied
  /// to quads and back at every evaluation. Allocates.
  void take(const SpringSet<Real>& springs, bool damped, int spacing);
  [[nodiscard]] bool empty() const { return fans_.empty(); }
  /// Adds the forces of all springs to f.
  void add(const Real* q, const Real* v, Real* f) noexcept { add_with(force_, q, v, f); }
  /// add(), and returns the springs' energy [J].
  double measure(const Real* q, const Real* v, Real* f) noexcept { return add_with(measured_force_, q, v, f); }
  /// For vectors of quads; see fans::Move.
  [[nodiscard]] double advance(const fans::Move<Real>& move, long nodes) const noexcept {
    return kernels_.advance(move, nodes);
  }
  [[nodiscard]] std::size_t memory_bytes() const {
    return fans_.size() * sizeof(fans::Fan) + partners_.size() * sizeof(int) +
           (numbers_.size() + q_.size() + v_.size() + f_.size()) * sizeof(Real);
  }

 private:
  /// A spring as one of its ends sees it.
  struct Member {
    int partner;  ///< a node
    Real stiffness;
    Real viscosity;
    Real rest_length;
  };
  void add_fan(int node, std::span<const Member> members);
  /// Quads of one's own, for vectors without.
  void make_quads(const SpringSet<Real>& springs);
  double add_with(fans::Force<Real> kernel, const Real* q, const Real* v, Real* f) noexcept;

  fans::Kernels<Real> kernels_;
  bool damped_ = true;
  fans::Force<Real> force_ = nullptr;
  fans::Force<Real> measured_force_ = nullptr;
  std::vector<fans::Fan> fans_;
  std::vector<int> partners_;
  AlignedVector<Real> numbers_;
  long free_nodes_ = 0;
  AlignedVector<Real> q_, v_, f_;  ///< free nodes, then places that never move; empty where the vectors have quads
};

}  // namespace palpate
