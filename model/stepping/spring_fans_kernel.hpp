// SPDX-License-Identifier: MIT
#pragma once
/// The loop over springs in fans for one instruction set. Included by one source file per instruction set;
/// includes no code that other files compile too.

#include <xsimd/xsimd.hpp>

#include "model/stepping/fused.hpp"
#include "model/stepping/quads.hpp"
#include "model/stepping/spring_fans_view.hpp"
#include "model/stepping/spring_length.hpp"

namespace palpate::fans {

template <bool is_damped, bool is_measured, class Real, class Arch>
class FanLoop {
 public:
  using Four = Quads<Real, Arch>;
  using Quad = typename Four::Quad;
  using Batch = xsimd::batch<Real, Arch>;
  static constexpr long lanes = static_cast<long>(Batch::size);
  static constexpr long width = node_numbers(is_damped);
  static_assert(View<Real>::zero_length > Real(0));

  explicit FanLoop(const View<Real>& view) noexcept
      : free_nodes_(view.free_nodes),
        nodes_(view.nodes),
        states_(view.states),
        forces_(view.forces),
        partners_(view.partners),
        numbers_(view.numbers) {}

  void begin(const Real* q, const Real* v) noexcept {
    Real* state = states_;
    for (long n = 0; n < free_nodes_; ++n, state += width) {
      Four::store(Four::three(q + 3 * n), state);
      if constexpr (is_damped) { Four::store(Four::three(v + 3 * n), state + quad); }
      Four::store(Quad{}, forces_ + quad * n);
    }
    for (long n = free_nodes_; n < nodes_; ++n) { Four::store(Quad{}, forces_ + quad * n); }
  }
  void pass(const Fan& fan) noexcept {
    const Real* state = states_ + fan.node;
    place_ = Four::load(state);
    if constexpr (is_damped) { velocity_ = Four::load(state + quad); }
    Quad force{};
    for (int n = 0; n < fan.groups; ++n) { force = group(force); }
    Real* to = force_at(fan.node);
    Four::store(Four::load(to) + force, to);
  }
  void end(Real* f) const noexcept {
    for (long n = 0; n < free_nodes_; ++n) {
      for (long c = 0; c < 3; ++c) { f[3 * n + c] += forces_[quad * n + c]; }
    }
  }
  [[nodiscard]] double energy() const noexcept { return 0.5 * static_cast<double>(xsimd::hadd(energy_)); }

 private:
  static Batch load(const Real* from) noexcept { return Batch::load_unaligned(from); }
  /// Of the node whose state begins there.
  [[nodiscard]] Real* force_at(long state) const noexcept {
    return reinterpret_cast<Real*>(reinterpret_cast<char*>(forces_) +
                                   state * static_cast<long>(sizeof(Real)) / (width / quad));
  }
  /// Tension over length, of springs of that squared length, and that rate times the length.
  Batch pull(const Batch& square, const Quad* closing) noexcept {
    const SpringLengths<Real, Arch> lengths(square, View<Real>::zero_length);
    const Batch inverse = lengths.inverse();
    const Batch extension = lengths.length() - load(numbers_ + lanes);
    Batch tension = load(numbers_) * extension;
    if constexpr (is_measured) { energy_ = fused::add(tension, extension, energy_); }
    if constexpr (is_damped) {
      tension = fused::add(load(numbers_ + 2 * lanes), Four::sums(closing) * inverse, tension);
    }
    return tension * inverse;
  }
  /// Adds to the force on the node, and to those on the others.
  Quad group(Quad force) noexcept {
    Quad d[lanes];
    Quad squares[lanes];
    Quad closing[lanes];
    for (long n = 0; n < lanes; ++n) {
      const Real* far = states_ + partners_[n];
      d[n] = Four::load(far) - place_;
      squares[n] = d[n] * d[n];
      if constexpr (is_damped) { closing[n] = (Four::load(far + quad) - velocity_) * d[n]; }
    }
    Real factor[lanes];
    pull(Four::sums(squares), closing).store_unaligned(factor);
    for (long n = 0; n < lanes; ++n) {
      Real* to = force_at(partners_[n]);
      const Quad all = Four::all(factor[n]);
      force = Four::add(all, d[n], force);
      Four::store(Four::add(-all, d[n], Four::load(to)), to);
    }
    partners_ += lanes;
    numbers_ += group_numbers(is_damped) * lanes;
    return force;
  }

  long free_nodes_;
  long nodes_;
  Real* states_;
  Real* forces_;
  const int* partners_;
  const Real* numbers_;
  Quad place_{};
  Quad velocity_{};
  Batch energy_ = Batch(Real(0));
};

template <bool is_damped, bool is_measured, class Real, class Arch>
double pass_all(const View<Real>& view, const Real* q, const Real* v, Real* f) noexcept {
  FanLoop<is_damped, is_measured, Real, Arch> loop(view);
  loop.begin(q, v);
  for (long n = 0; n < view.count; ++n) { loop.pass(view.fans[n]); }
  loop.end(f);
  return loop.energy();
}
template <bool is_damped, class Real, class Arch>
void add_forces(const View<Real>& view, const Real* q, const Real* v, Real* f) noexcept {
  pass_all<is_damped, false, Real, Arch>(view, q, v, f);
}
template <bool is_damped, class Real, class Arch>
double measure_forces(const View<Real>& view, const Real* q, const Real* v, Real* f) noexcept {
  return pass_all<is_damped, true, Real, Arch>(view, q, v, f);
}

template <class Real, class Arch>
Kernels<Real> kernels_for(const char* name) noexcept {
  return {.name = name,
          .lanes = static_cast<int>(xsimd::batch<Real, Arch>::size),
          .damped = &add_forces<true, Real, Arch>,
          .damped_measured = &measure_forces<true, Real, Arch>,
          .undamped = &add_forces<false, Real, Arch>,
          .undamped_measured = &measure_forces<false, Real, Arch>};
}

}  // namespace palpate::fans
