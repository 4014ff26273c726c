// SPDX-License-Identifier: MIT
#pragma once
/// Places, velocities and forces of one node each, four numbers at a time. Included by one source
/// file per instruction set; `Arch` makes functions of that instruction set alone.

#include <bit>
#include <type_traits>
#include <xsimd/xsimd.hpp>

#include "model/kernels/kernel_views.hpp"
#include "model/kernels/simd.hpp"

namespace palpate::fans {

/// Four numbers in one register, or in two where registers are short, in the compiler's own
/// vectors: four doubles are two of SSE's registers, which no xsimd batch is.
template <class Real, class Arch> struct Quads {
  static constexpr long lanes = static_cast<long>(xsimd::batch<Real, Arch>::size);
  using Batch = xsimd::batch<Real, Arch>;
  typedef Real Quad __attribute__((vector_size(quad * sizeof(Real))));
  template <long size> struct Row {
    typedef Real Type __attribute__((vector_size(size * sizeof(Real))));
  };

  static Quad load(const Real* from) noexcept {
    Quad to;
    __builtin_memcpy(&to, from, sizeof to);
    return to;
  }
  static Quad three(const Real* from) noexcept { return Quad{from[0], from[1], from[2], Real(0)}; }
  static void store(const Quad& from, Real* to) noexcept {
    __builtin_memcpy(to, &from, sizeof from);
  }
  static Quad all(Real number) noexcept { return Quad{number, number, number, number}; }
  /// a b + c, rounded once where the processor can.
  static Quad add(const Quad& a, const Quad& b, const Quad& c) noexcept {
#if defined(__FMA__)
    if constexpr (std::is_same_v<Real, double>) {
      return Quad(_mm256_fmadd_pd(__m256d(a), __m256d(b), __m256d(c)));
    }
    if constexpr (std::is_same_v<Real, float>) {
      return Quad(_mm_fmadd_ps(__m128(a), __m128(b), __m128(c)));
    }
#endif
    return c + a * b;
  }

  /// The sum of each of `lanes` quads.
  static Batch sums(const Quad* quads) noexcept {
    return Batch(std::bit_cast<typename Batch::register_type>(row<lanes>(quads)));
  }

 private:
  template <long size> static typename Row<size>::Type row(const Quad* quads) noexcept {
    if constexpr (size == 2) {
      const Quad both = halves(quads[0], quads[1]);
      return __builtin_shufflevector(both, both, 0, 1) + __builtin_shufflevector(both, both, 2, 3);
    } else if constexpr (sizeof(Quad) == 16) {
      return neighbours(neighbours(quads[0], quads[1]), neighbours(quads[2], quads[3]));
    } else {
      const Quad first = halves(quads[0], quads[1]);
      const Quad second = halves(quads[2], quads[3]);
      return __builtin_shufflevector(first, second, 0, 1, 6, 7) +
             __builtin_shufflevector(first, second, 2, 3, 4, 5);
    }
  }
  /// (a0 + a1, a2 + a3, b0 + b1, b2 + b3)
  static Quad neighbours(const Quad& a, const Quad& b) noexcept {
    return __builtin_shufflevector(a, b, 0, 2, 4, 6) + __builtin_shufflevector(a, b, 1, 3, 5, 7);
  }
  /// (a0 + a1, b1 + b0, a2 + a3, b3 + b2), which stays within halves of a long register.
  static Quad halves(const Quad& a, const Quad& b) noexcept {
    return __builtin_shufflevector(a, b, 0, 5, 2, 7) + __builtin_shufflevector(a, b, 1, 4, 3, 6);
  }
};

// The loop over springs in fans for one instruction set. Included by one source file per
// instruction set; includes no code that other files compile too.

template <bool is_damped, bool is_measured, class Real, class Arch> class FanLoop {
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
    const SpringNumbers<Batch> spring{
        .stiffness = load(numbers_),
        .rest = load(numbers_ + lanes),
        .viscosity = is_damped ? load(numbers_ + 2 * lanes) : Batch(Real(0))};
    if constexpr (is_measured) {
      energy_ = add_twice_energy(spring, Batch(lengths.length()), energy_);
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
  /// Adds to the force on the node, and to those on the others; d and its rate lead from them to
  /// it.
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
template <class Real, class Arch> double advance(const Move<Real>& move, long nodes) noexcept {
  using Four = Quads<Real, Arch>;
  using Quad = typename Four::Quad;
  const Quad h = Four::all(move.h);
  const auto step = [&](long node, Quad& squares) {
    const long n = quad * node;
    const Quad v =
        Four::load(move.v + n) + h * (Four::load(move.f + n) * Four::load(move.inverse_mass + n));
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

template <class Real, class Arch> Kernels<Real> kernels_for(const char* name) noexcept {
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
