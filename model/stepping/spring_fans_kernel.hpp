// SPDX-License-Identifier: MIT
#pragma once
/// The loop over springs in fans for one instruction set. Included by one source file per instruction set;
/// includes no code that other files compile too.

#include <utility>

#include <xsimd/xsimd.hpp>

#include "model/stepping/fused.hpp"
#include "model/stepping/spring_fans_view.hpp"
#include "model/stepping/spring_length.hpp"

namespace palpate::fans {

template <bool measured, class Real, class Arch>
class FanLoop {
 public:
  using Batch = xsimd::batch<Real, Arch>;
  static constexpr long lanes = static_cast<long>(Batch::size);
  static_assert(View<Real>::zero_length > Real(0));

  FanLoop(const View<Real>& view, const Real* q, const Real* v, Real* f) noexcept
      : q_(q), v_(v), f_(f), partners_(view.partners), numbers_(view.numbers) {}

  void pass(const Fan& fan) noexcept {
    for (int c = 0; c < 3; ++c) {
      place_[c] = Batch(q_[fan.node + c]);
      velocity_[c] = Batch(v_[fan.node + c]);
      force_[c] = Batch(Real(0));
    }
    for (int n = 0; n < fan.links; ++n) { link(); }
    for (int n = 0; n < fan.anchors; ++n) { anchor(); }
    for (int c = 0; c < 3; ++c) { f_[fan.node + c] += xsimd::hadd(force_[c]); }
  }
  [[nodiscard]] double energy() const noexcept { return 0.5 * static_cast<double>(xsimd::hadd(energy_)); }

 private:
  static Batch load(const Real* from) noexcept { return Batch::load_unaligned(from); }
  template <std::size_t... lane>
  Batch collect(const Real* from, std::index_sequence<lane...>) const noexcept {
    return Batch(typename Batch::register_type{from[partners_[lane]]...});  // not by way of memory
  }
  Batch collect(const Real* from) const noexcept {
    return collect(from, std::make_index_sequence<static_cast<std::size_t>(lanes)>{});
  }
  /// Springs to d[] away, whose far ends move by w[] against the node: tension over length.
  Batch pull(const Batch* d, const Batch* w) noexcept {
    const SpringLengths<Real, Arch> lengths(fused::add(d[2], d[2], fused::add(d[1], d[1], d[0] * d[0])),
                                            View<Real>::zero_length);
    const Batch inverse = lengths.inverse();
    const Batch extension = lengths.length() - load(numbers_ + 2 * lanes);
    const Batch elastic = load(numbers_) * extension;
    if constexpr (measured) { energy_ = fused::add(elastic, extension, energy_); }
    const Batch rate = fused::add(w[2], d[2], fused::add(w[1], d[1], w[0] * d[0])) * inverse;
    return fused::add(load(numbers_ + lanes), rate, elastic) * inverse;
  }
  void link() noexcept {
    Batch d[3];
    Batch w[3];
    for (int c = 0; c < 3; ++c) {
      d[c] = collect(q_ + c) - place_[c];
      w[c] = collect(v_ + c) - velocity_[c];
    }
    const Batch factor = pull(d, w);
    Real share[3][lanes];
    for (int c = 0; c < 3; ++c) {
      const Batch force = factor * d[c];
      force_[c] += force;
      force.store_unaligned(share[c]);
    }
    for (long n = 0; n < lanes; ++n) {
      Real* f = f_ + partners_[n];
      for (int c = 0; c < 3; ++c) { f[c] -= share[c][n]; }
    }
    partners_ += lanes;
    numbers_ += link_numbers * lanes;
  }
  void anchor() noexcept {
    Batch d[3];
    Batch w[3];
    for (int c = 0; c < 3; ++c) {
      d[c] = load(numbers_ + (link_numbers + c) * lanes) - place_[c];
      w[c] = -velocity_[c];
    }
    const Batch factor = pull(d, w);
    for (int c = 0; c < 3; ++c) { force_[c] = fused::add(factor, d[c], force_[c]); }
    numbers_ += anchor_numbers * lanes;
  }

  const Real* q_;
  const Real* v_;
  Real* f_;
  const int* partners_;
  const Real* numbers_;
  Batch place_[3]{};
  Batch velocity_[3]{};
  Batch force_[3]{};
  Batch energy_ = Batch(Real(0));
};

template <class Real, class Arch>
void add_forces(const View<Real>& view, const Real* q, const Real* v, Real* f) noexcept {
  FanLoop<false, Real, Arch> loop(view, q, v, f);
  for (long n = 0; n < view.count; ++n) { loop.pass(view.fans[n]); }
}

template <class Real, class Arch>
double measure_forces(const View<Real>& view, const Real* q, const Real* v, Real* f) noexcept {
  FanLoop<true, Real, Arch> loop(view, q, v, f);
  for (long n = 0; n < view.count; ++n) { loop.pass(view.fans[n]); }
  return loop.energy();
}

template <class Real, class Arch>
Kernels<Real> kernels_for(const char* name) noexcept {
  return {.name = name,
          .lanes = static_cast<int>(xsimd::batch<Real, Arch>::size),
          .force = &add_forces<Real, Arch>,
          .measured_force = &measure_forces<Real, Arch>};
}

}  // namespace palpate::fans
