// SPDX-License-Identifier: MIT
#pragma once
/// Lengths of springs and their inverses, a vector at a time. Included by one source file per instruction set; `Arch`
/// makes functions of that instruction set alone.

#include <bit>

#include <xsimd/xsimd.hpp>

#include "model/stepping/fused.hpp"

namespace palpate {

#if defined(__AVX512F__)
/// From the processor's estimate of 1 / sqrt(square), good to 2^-14: with r = 1 - square estimate^2 it is the estimate
/// times (1 - r)^(-1/2), by the series of that, without the divider. What waits for r is short: much else waits for this.
template <class Arch>
xsimd::batch<double, Arch> inverse_root(const xsimd::batch<double, Arch>& square) noexcept {
  using Batch = xsimd::batch<double, Arch>;
  const Batch estimate = _mm512_rsqrt14_pd(square);
  const Batch r = fused::subtract(square * estimate, estimate, Batch(1.0));
  const Batch series = fused::add(fused::add(Batch(0.3125), r, Batch(0.375)), r, Batch(0.5));
  return fused::add(estimate * r, series, estimate);
}
template <class Arch>
xsimd::batch<float, Arch> inverse_root(const xsimd::batch<float, Arch>& square) noexcept {
  using Batch = xsimd::batch<float, Arch>;
  const Batch estimate = _mm512_rsqrt14_ps(square);
  const Batch r = fused::subtract(square * estimate, estimate, Batch(1.0F));
  return fused::add(r, Batch(0.5F) * estimate, estimate);
}
inline __mmask8 above(const __m512d& square, double least) noexcept {
  return _mm512_cmpgt_epi64_mask(_mm512_castpd_si512(square), _mm512_castpd_si512(_mm512_set1_pd(least)));
}
inline __mmask16 above(const __m512& square, float least) noexcept {
  return _mm512_cmpgt_epi32_mask(_mm512_castps_si512(square), _mm512_castps_si512(_mm512_set1_ps(least)));
}
/// Where `there` is set, and 0 elsewhere: a b, and c - a b.
inline __m512d multiply(__mmask8 there, const __m512d& a, const __m512d& b) noexcept {
  return _mm512_maskz_mul_pd(there, a, b);
}
inline __m512 multiply(__mmask16 there, const __m512& a, const __m512& b) noexcept {
  return _mm512_maskz_mul_ps(there, a, b);
}
inline __m512d subtract(__mmask8 there, const __m512d& a, const __m512d& b, const __m512d& c) noexcept {
  return _mm512_maskz_fnmadd_pd(there, a, b, c);
}
inline __m512 subtract(__mmask16 there, const __m512& a, const __m512& b, const __m512& c) noexcept {
  return _mm512_maskz_fnmadd_ps(there, a, b, c);
}
#endif

/// Stiffness, natural length and viscosity of springs.
template <class Batch>
struct SpringNumbers {
  Batch stiffness;  ///< [N/m]
  Batch rest;       ///< [m]
  Batch viscosity;  ///< [N s/m]; unused where there are no dampers
};

/// From a square root and a quotient.
template <class Real, class Arch, bool estimated = fused::is_avx512<Arch>>
class SpringLengths {
 public:
  using Batch = xsimd::batch<Real, Arch>;

  /// Of springs whose squared lengths are `square`; those of `zero_length` or less have none.
  SpringLengths(const Batch& square, Real zero_length) noexcept : zero_length_(zero_length), length_(xsimd::sqrt(square)) {}
  [[nodiscard]] const Batch& length() const noexcept { return length_; }
  /// Tension over length; 0 where there is no length.
  [[nodiscard]] Batch pull(const SpringNumbers<Batch>& spring) const noexcept {
    return spring.stiffness * (length_ - spring.rest) * inverse();
  }
  /// With dampers; `rate` is that of the length, times the length.
  [[nodiscard]] Batch pull(const SpringNumbers<Batch>& spring, const Batch& rate) const noexcept {
    const Batch inverse = this->inverse();
    return fused::add(spring.viscosity, rate * inverse, spring.stiffness * (length_ - spring.rest)) * inverse;
  }

 private:
  /// 0 where there is no length.
  [[nodiscard]] Batch inverse() const noexcept {
    const auto has_length = length_ > Batch(zero_length_);
    const Batch inverse = Batch(Real(1)) / length_;
    if constexpr (sizeof(has_length) == sizeof(Batch)) {
      return std::bit_cast<Batch>(has_length) & inverse;  // select() takes an instruction more
    } else {
      return xsimd::select(has_length, inverse, Batch(Real(0)));
    }
  }

  Real zero_length_;
  Batch length_;
};

#if defined(__AVX512F__)
/// From the processor's estimate. Tension over length is k - (k L - c rate / length) / length: two operations less, at a
/// rounding more of k, where the divider does not set the pace.
template <class Real, class Arch>
class SpringLengths<Real, Arch, true> {
 public:
  using Batch = xsimd::batch<Real, Arch>;
  SpringLengths(const Batch& square, Real zero_length) noexcept
      : square_(square), has_length_(above(square, zero_length * zero_length)), inverse_(inverse_root(square)) {}
  [[nodiscard]] Batch length() const noexcept { return multiply(has_length_, square_, inverse_); }
  [[nodiscard]] Batch pull(const SpringNumbers<Batch>& spring) const noexcept {
    return subtract(has_length_, spring.stiffness * spring.rest, inverse_, spring.stiffness);
  }
  [[nodiscard]] Batch pull(const SpringNumbers<Batch>& spring, const Batch& rate) const noexcept {
    const Batch less = fused::subtract(spring.viscosity * rate, inverse_, spring.stiffness * spring.rest);
    return subtract(has_length_, less, inverse_, spring.stiffness);
  }

 private:
  Batch square_;
  std::conditional_t<std::is_same_v<Real, double>, __mmask8, __mmask16> has_length_;
  Batch inverse_;  ///< anything where there is no length
};
#endif

}  // namespace palpate
