// SPDX-License-Identifier: MIT
#pragma once
/// The springs of a list, gathered by the node that they begin at, so that as many as a register holds are
/// computed at once. Equals spring_kernel_for({.damped = true}) to rounding.

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
  /// Links and anchors, sorted by the coordinate a; allocates.
  void take(const SpringSet<Real>& springs);
  [[nodiscard]] bool empty() const { return fans_.empty(); }
  void add(const Real* q, const Real* v, Real* f) const noexcept { kernels_.force(view(), q, v, f); }
  /// add(), and returns the springs' energy [J].
  double measure(const Real* q, const Real* v, Real* f) const noexcept {
    return kernels_.measured_force(view(), q, v, f);
  }
  [[nodiscard]] std::size_t memory_bytes() const {
    return fans_.size() * sizeof(fans::Fan) + partners_.size() * sizeof(int) + numbers_.size() * sizeof(Real);
  }

 private:
  [[nodiscard]] fans::View<Real> view() const noexcept {
    return {.fans = fans_.data(),
            .count = static_cast<long>(fans_.size()),
            .partners = partners_.data(),
            .numbers = numbers_.data()};
  }
  void take_links(fans::Fan& fan, std::span<const Link<Real>> links);
  void take_anchors(fans::Fan& fan, std::span<const Anchor<Real>> anchors);

  fans::Kernels<Real> kernels_;
  std::vector<fans::Fan> fans_;
  std::vector<int> partners_;
  AlignedVector<Real> numbers_;
};

}  // namespace palpate
