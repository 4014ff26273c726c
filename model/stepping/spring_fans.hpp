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
  /// Links and anchors; without their dampers unless `damped`. Allocates.
  void take(const SpringSet<Real>& springs, bool damped);
  [[nodiscard]] bool empty() const { return fans_.empty(); }
  /// Adds the forces of all springs to f.
  void add(const Real* q, const Real* v, Real* f) noexcept { force_(view(), q, v, f); }
  /// add(), and returns the springs' energy [J].
  double measure(const Real* q, const Real* v, Real* f) noexcept { return measured_force_(view(), q, v, f); }
  [[nodiscard]] std::size_t memory_bytes() const {
    return fans_.size() * sizeof(fans::Fan) + partners_.size() * sizeof(int) +
           (numbers_.size() + states_.size() + forces_.size()) * sizeof(Real);
  }

 private:
  /// A spring as one of its ends sees it.
  struct Member {
    int partner;
    Real stiffness;
    Real viscosity;
    Real rest_length;
  };
  [[nodiscard]] fans::View<Real> view() noexcept {
    return {.fans = fans_.data(),
            .count = static_cast<long>(fans_.size()),
            .partners = partners_.data(),
            .numbers = numbers_.data(),
            .free_nodes = free_nodes_,
            .nodes = static_cast<long>(forces_.size()) / fans::quad,
            .states = states_.data(),
            .forces = forces_.data()};
  }
  /// The nodes of the anchors: one for each of their places.
  std::vector<int> place_nodes(const SpringSet<Real>& springs);
  void add_fan(int node, std::span<const Member> members);

  fans::Kernels<Real> kernels_;
  bool damped_ = true;
  fans::Force<Real> force_ = nullptr;
  fans::MeasuredForce<Real> measured_force_ = nullptr;
  std::vector<fans::Fan> fans_;
  std::vector<int> partners_;
  AlignedVector<Real> numbers_;
  long free_nodes_ = 0;
  AlignedVector<Real> states_;
  AlignedVector<Real> forces_;
};

}  // namespace palpate
