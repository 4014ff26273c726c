// SPDX-License-Identifier: MIT
#pragma once
/// Multiplication and addition in one rounding, where the instruction set has it. Included by one source file per
/// instruction set; `Arch` makes functions of that instruction set alone.

#include <type_traits>

#include <xsimd/xsimd.hpp>

namespace palpate::fused {

/// Vectors of 512 bits, for which xsimd 8 has no such operation.
template <class Arch>
inline constexpr bool is_avx512 = std::is_base_of_v<xsimd::avx512f, Arch>;

/// a b + c
template <class Real, class Arch>
xsimd::batch<Real, Arch> add(const xsimd::batch<Real, Arch>& a, const xsimd::batch<Real, Arch>& b,
                             const xsimd::batch<Real, Arch>& c) noexcept {
#if defined(__AVX512F__)
  if constexpr (is_avx512<Arch>) {
    if constexpr (std::is_same_v<Real, double>) { return _mm512_fmadd_pd(a, b, c); }
    if constexpr (std::is_same_v<Real, float>) { return _mm512_fmadd_ps(a, b, c); }
  }
#endif
  return xsimd::fma(a, b, c);
}
/// c - a b
template <class Real, class Arch>
xsimd::batch<Real, Arch> subtract(const xsimd::batch<Real, Arch>& a, const xsimd::batch<Real, Arch>& b,
                                  const xsimd::batch<Real, Arch>& c) noexcept {
#if defined(__AVX512F__)
  if constexpr (is_avx512<Arch>) {
    if constexpr (std::is_same_v<Real, double>) { return _mm512_fnmadd_pd(a, b, c); }
    if constexpr (std::is_same_v<Real, float>) { return _mm512_fnmadd_ps(a, b, c); }
  }
#endif
  return xsimd::fnma(a, b, c);
}

}  // namespace palpate::fused
