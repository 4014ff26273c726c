// SPDX-License-Identifier: MIT
#pragma once
/// Places, velocities and forces of one node each, four numbers at a time. Included by one source file per instruction
/// set; `Arch` makes functions of that instruction set alone.

#include <bit>
#include <type_traits>

#include <xsimd/xsimd.hpp>

#include "model/stepping/spring_fans_view.hpp"

namespace palpate::fans {

/// Four numbers in one register, or in two where registers are short, in the compiler's own vectors: four doubles are
/// two of SSE's registers, which no xsimd batch is.
template <class Real, class Arch>
struct Quads {
  static constexpr long lanes = static_cast<long>(xsimd::batch<Real, Arch>::size);
  using Batch = xsimd::batch<Real, Arch>;
  typedef Real Quad __attribute__((vector_size(quad * sizeof(Real))));
  template <long size>
  struct Row {
    typedef Real Type __attribute__((vector_size(size * sizeof(Real))));
  };

  static Quad load(const Real* from) noexcept {
    Quad to;
    __builtin_memcpy(&to, from, sizeof to);
    return to;
  }
  static Quad three(const Real* from) noexcept { return Quad{from[0], from[1], from[2], Real(0)}; }
  static void store(const Quad& from, Real* to) noexcept { __builtin_memcpy(to, &from, sizeof from); }
  static Quad all(Real number) noexcept { return Quad{number, number, number, number}; }
  /// a b + c, rounded once where the processor can.
  static Quad add(const Quad& a, const Quad& b, const Quad& c) noexcept {
#if defined(__FMA__)
    if constexpr (std::is_same_v<Real, double>) { return Quad(_mm256_fmadd_pd(__m256d(a), __m256d(b), __m256d(c))); }
    if constexpr (std::is_same_v<Real, float>) { return Quad(_mm_fmadd_ps(__m128(a), __m128(b), __m128(c))); }
#endif
    return c + a * b;
  }

  /// The sum of each of `lanes` quads.
  static Batch sums(const Quad* quads) noexcept {
    return Batch(std::bit_cast<typename Batch::register_type>(row<lanes>(quads)));
  }

 private:
  template <long size>
  static typename Row<size>::Type row(const Quad* quads) noexcept {
    if constexpr (size == 2) {
      const Quad both = halves(quads[0], quads[1]);
      return __builtin_shufflevector(both, both, 0, 1) + __builtin_shufflevector(both, both, 2, 3);
    } else if constexpr (sizeof(Quad) == 16) {
      return neighbours(neighbours(quads[0], quads[1]), neighbours(quads[2], quads[3]));
    } else {
      const Quad first = halves(quads[0], quads[1]);
      const Quad second = halves(quads[2], quads[3]);
      return __builtin_shufflevector(first, second, 0, 1, 6, 7) + __builtin_shufflevector(first, second, 2, 3, 4, 5);
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

}  // namespace palpate::fans
