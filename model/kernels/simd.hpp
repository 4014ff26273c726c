// SPDX-License-Identifier: MIT
#pragma once
/// Forces inlining of the code of a step. Sanitizer builds use calls: inlining would make
/// compilation take minutes.

#include <type_traits>
#include <xsimd/xsimd.hpp>

#include "model/problem/spring_law.hpp"

#if defined(PALPATE_SANITIZED)
#define PALPATE_ALWAYS_INLINE
#else
#define PALPATE_ALWAYS_INLINE __attribute__((always_inline))
#endif

namespace palpate::fused {

// Multiplication and addition with one rounding, if the instruction set supports it. One source
// file per instruction set includes this header; `Arch` gives each its own functions.

/// True for 512-bit vectors, for which xsimd 8 has no fused operation.
template <class Arch> inline constexpr bool is_avx512 = std::is_base_of_v<xsimd::avx512f, Arch>;

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
xsimd::batch<Real, Arch> subtract(const xsimd::batch<Real, Arch>& a,
                                  const xsimd::batch<Real, Arch>& b,
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

namespace palpate {

template <class Real, class Arch> struct MultiplyAdd<xsimd::batch<Real, Arch>> {
  using Batch = xsimd::batch<Real, Arch>;
  PALPATE_ALWAYS_INLINE static Batch of(const Batch& a, const Batch& b, const Batch& c) noexcept {
    return fused::add(a, b, c);
  }
};

#if defined(__AVX512F__)
/// Returns 1 / sqrt(square) from the processor's estimate with a relative error of 2^-14. With r =
/// 1 - square estimate^2, the result is the estimate times the series of (1 - r)^(-1/2), without a
/// division. The dependency chain after r is short, because r is available late.
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
  // Half of the estimate: the exponent less one, without a multiplication.
  const __m512i half = _mm512_sub_epi32(_mm512_castps_si512(estimate), _mm512_set1_epi32(1 << 23));
  return fused::add(r, Batch(_mm512_castsi512_ps(half)), estimate);
}
#endif

/// Offset added to squared lengths [m^2]. It keeps 1 / length finite, so that springs of zero
/// length exert no force. For lengths above 1e-6 m it is below rounding error.
template <class Real> inline constexpr Real least_square = Real(1e-30);
static_assert(least_square<double> < 0.5 * 2.2e-16 * 1e-6 * 1e-6);

/// Lengths of springs from a square root and a division. `square` is the squared length plus
/// least_square.
template <class Real, class Arch, bool estimated = fused::is_avx512<Arch>> class SpringLengths {
 public:
  using Batch = xsimd::batch<Real, Arch>;

  SpringLengths() noexcept = default;
  explicit SpringLengths(const Batch& square) noexcept : length_(xsimd::sqrt(square)) {}
  [[nodiscard]] const Batch& length() const noexcept { return length_; }
  /// Returns tension over length without dampers.
  [[nodiscard]] Batch pull(const SpringNumbers<Batch>& spring) const noexcept {
    return SpringTension<SpringTerms{.viscous = false}>::of(spring, length_, length_) * inverse();
  }
  /// Returns tension over length with dampers; `rate` is L' times the length.
  [[nodiscard]] Batch pull(const SpringNumbers<Batch>& spring, const Batch& rate) const noexcept {
    const Batch inverse = this->inverse();
    return SpringTension<>::of(spring, length_, Batch(rate * inverse)) * inverse;
  }

 private:
  [[nodiscard]] Batch inverse() const noexcept { return Batch(Real(1)) / length_; }

  Batch length_;
};

#if defined(__AVX512F__)
/// Lengths of springs from the processor's estimate. Tension over length is k - (k L - c rate /
/// length) / length: two operations less, with one more rounding of k.
template <class Real, class Arch> class SpringLengths<Real, Arch, true> {
 public:
  using Batch = xsimd::batch<Real, Arch>;
  SpringLengths() noexcept = default;
  explicit SpringLengths(const Batch& square) noexcept
      : square_(square), inverse_(inverse_root(square)) {}
  [[nodiscard]] Batch length() const noexcept { return square_ * inverse_; }
  [[nodiscard]] Batch pull(const SpringNumbers<Batch>& spring) const noexcept {
    return fused::subtract(spring.stiffness * spring.rest, inverse_, spring.stiffness);
  }
  [[nodiscard]] Batch pull(const SpringNumbers<Batch>& spring, const Batch& rate) const noexcept {
    const Batch less =
        fused::subtract(spring.viscosity * rate, inverse_, spring.stiffness * spring.rest);
    return fused::subtract(less, inverse_, spring.stiffness);
  }

 private:
  Batch square_;
  Batch inverse_;
};
#endif

}  // namespace palpate
