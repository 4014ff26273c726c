// SPDX-License-Identifier: MIT
#pragma once
/// The loop over springs in fans for one instruction set. Included by one source file per instruction set;
/// includes no code that other files compile too.

#include <xsimd/xsimd.hpp>

#include "model/stepping/always_inline.hpp"
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

  FanLoop(const View<Real>& view, const Real* q, const Real* v, Real* f) noexcept
      : q_(q), v_(v), f_(f), partners_(view.partners), numbers_(view.numbers) {}

  void pass(const Fan& fan) noexcept {
    place_ = Four::load(q_ + fan.node);
    if constexpr (is_damped) { velocity_ = Four::load(v_ + fan.node); }
    Quad force{};
    for (int n = 0; n < fan.groups; ++n) { force = group(force); }
    Four::store(Four::load(f_ + fan.node) + force, f_ + fan.node);
  }
  [[nodiscard]] double energy() const noexcept {
    if constexpr (!is_measured) { return 0.0; }
    return 0.5 * static_cast<double>(xsimd::hadd(energy_));
  }

 private:
  static Batch load(const Real* from) noexcept { return Batch::load_unaligned(from); }
  /// Tension over length, of springs of that squared length, and that rate times the length.
  Batch pull(const Batch& square, const Quad* closing) noexcept {
    const SpringLengths<Real, Arch> lengths(square + Batch(least_square<Real>));
    const SpringNumbers<Batch> spring{.stiffness = load(numbers_),
                                      .rest = load(numbers_ + lanes),
                                      .viscosity = is_damped ? load(numbers_ + 2 * lanes) : Batch(Real(0))};
    if constexpr (is_measured) {
      const Batch extension = lengths.length() - spring.rest;
      energy_ = fused::add(spring.stiffness * extension, extension, energy_);
    }
    if constexpr (is_damped) { return lengths.pull(spring, Four::sums(closing)); }
    return lengths.pull(spring);
  }
  /// They come as a stream that outruns what processors foresee (docs/bench.md). Always inline:
  /// g++ 12 leaves a call out that does nothing else.
  PALPATE_ALWAYS_INLINE inline void fetch_ahead() noexcept {
    constexpr long length = group_numbers(is_damped) * lanes;
    for (long n = 0; n < length; n += 64 / static_cast<long>(sizeof(Real))) {
      __builtin_prefetch(numbers_ + groups_ahead * length + n);
    }
    __builtin_prefetch(partners_ + groups_ahead * lanes);
  }
  /// Adds to the force on the node, and to those on the others; d and its rate lead from them to it.
  Quad group(Quad force) noexcept {
    fetch_ahead();
    long far[lanes];
    Quad d[lanes];
    Quad squares[lanes];
    Quad closing[lanes];
    for (long n = 0; n < lanes; ++n) {
      far[n] = partners_[n];
      d[n] = place_ - Four::load(q_ + far[n]);
      squares[n] = d[n] * d[n];
      if constexpr (is_damped) { closing[n] = (velocity_ - Four::load(v_ + far[n])) * d[n]; }
    }
    Real factor[lanes];
    pull(Four::sums(squares), closing).store_unaligned(factor);
    for (long n = 0; n < lanes; ++n) {
      const Quad all = Four::all(factor[n]);
      force = Four::add(-all, d[n], force);
      Four::store(Four::add(all, d[n], Four::load(f_ + far[n])), f_ + far[n]);
    }
    partners_ += lanes;
    numbers_ += group_numbers(is_damped) * lanes;
    return force;
  }

  const Real* q_;
  const Real* v_;
  Real* f_;
  const int* partners_;
  const Real* numbers_;
  Quad place_{};
  Quad velocity_{};
  Batch energy_ = Batch(Real(0));
};

template <bool is_damped, bool is_measured, class Real, class Arch>
double pass_all(const View<Real>& view, const Real* q, const Real* v, Real* f) noexcept {
  FanLoop<is_damped, is_measured, Real, Arch> loop(view, q, v, f);
  for (long n = 0; n < view.count; ++n) { loop.pass(view.fans[n]); }
  return loop.energy();
}
template <class Real, class Arch>
void spread(const Real* packed, long nodes, Real* quads) noexcept {
  using Four = Quads<Real, Arch>;
  for (long n = 0; n < nodes; ++n) { Four::store(Four::three(packed + 3 * n), quads + quad * n); }
}
template <class Real, class Arch>
void collect(const Real* quads, long nodes, Real* packed) noexcept {
  for (long n = 0; n < nodes; ++n) {
    for (long c = 0; c < 3; ++c) { packed[3 * n + c] += quads[quad * n + c]; }
  }
}
template <class Real, class Arch>
double advance(const Move<Real>& move, long nodes) noexcept {
  using Four = Quads<Real, Arch>;
  using Quad = typename Four::Quad;
  const Quad h = Four::all(move.h);
  const auto step = [&](long node, Quad& squares) {
    const long n = quad * node;
    const Quad v = Four::load(move.v + n) + h * (Four::load(move.f + n) * Four::load(move.inverse_mass + n));
    Four::store(v, move.v + n);
    Four::store(Four::load(move.q + n) + h * v, move.q + n);
    Four::store(move.weight != nullptr ? Four::load(move.weight + n) : Quad{}, move.f + n);
    squares = Four::add(v, v, squares);
  };
  constexpr long sums = 4;  // none waits for another
  Quad squares[sums] = {};
  long node = 0;
  for (; node + sums <= nodes; node += sums) {
    for (long n = 0; n < sums; ++n) { step(node + n, squares[n]); }
  }
  for (; node < nodes; ++node) { step(node, squares[0]); }
  const Quad all = (squares[0] + squares[1]) + (squares[2] + squares[3]);
  return (static_cast<double>(all[0]) + static_cast<double>(all[1])) +
         (static_cast<double>(all[2]) + static_cast<double>(all[3]));
}

template <class Real, class Arch>
Kernels<Real> kernels_for(const char* name) noexcept {
  return {.name = name,
          .lanes = static_cast<int>(xsimd::batch<Real, Arch>::size),
          .damped = &pass_all<true, false, Real, Arch>,
          .damped_measured = &pass_all<true, true, Real, Arch>,
          .undamped = &pass_all<false, false, Real, Arch>,
          .undamped_measured = &pass_all<false, true, Real, Arch>,
          .spread = &spread<Real, Arch>,
          .collect = &collect<Real, Arch>,
          .advance = &advance<Real, Arch>};
}

}  // namespace palpate::fans
