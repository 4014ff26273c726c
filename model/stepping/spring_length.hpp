// SPDX-License-Identifier: MIT
#pragma once
/// Lengths of springs and their inverses, a vector at a time. Included by one source file per instruction set; `Arch`
/// makes functions of that instruction set alone.

#include <bit>

#include <xsimd/xsimd.hpp>

#include "model/stepping/fused.hpp"

namespace palpate {

#if defined(__AVX512F__)
/// `inverse` is the processor's estimate of 1 / sqrt(square), good to 2^-14. With r = 1 - square inverse^2 the length is
/// square inverse (1 - r)^(-1/2), by the series of that: without the divider. 0 for both where the estimate is 0.
template <class Arch>
void refine(const xsimd::batch<double, Arch>& square, xsimd::batch<double, Arch>& inverse,
            xsimd::batch<double, Arch>& length) noexcept {
  using Batch = xsimd::batch<double, Arch>;
  length = square * inverse;
  const Batch r = fused::subtract(length, inverse, Batch(1.0));
  const Batch more = r * fused::add(fused::add(Batch(0.3125), r, Batch(0.375)), r, Batch(0.5));
  length = fused::add(length, more, length);
  inverse = fused::add(inverse, more, inverse);
}
template <class Arch>
void refine(const xsimd::batch<float, Arch>& square, xsimd::batch<float, Arch>& inverse,
            xsimd::batch<float, Arch>& length) noexcept {
  using Batch = xsimd::batch<float, Arch>;
  length = square * inverse;
  const Batch more = Batch(0.5F) * fused::subtract(length, inverse, Batch(1.0F));
  length = fused::add(length, more, length);
  inverse = fused::add(inverse, more, inverse);
}
/// 0 where square is not above `least`.
template <class Arch>
xsimd::batch<double, Arch> estimate(const xsimd::batch<double, Arch>& square, double least) noexcept {
  return _mm512_maskz_rsqrt14_pd(_mm512_cmp_pd_mask(square, _mm512_set1_pd(least), _CMP_GT_OQ), square);
}
template <class Arch>
xsimd::batch<float, Arch> estimate(const xsimd::batch<float, Arch>& square, float least) noexcept {
  return _mm512_maskz_rsqrt14_ps(_mm512_cmp_ps_mask(square, _mm512_set1_ps(least), _CMP_GT_OQ), square);
}
#endif

template <class Real, class Arch>
class SpringLengths {
 public:
  using Batch = xsimd::batch<Real, Arch>;

  /// Of springs whose squared lengths are `square`; those of `zero_length` or less have none.
  SpringLengths(const Batch& square, Real zero_length) noexcept : zero_length_(zero_length) {
#if defined(__AVX512F__)
    if constexpr (estimated) {
      inverse_ = estimate(square, zero_length * zero_length);
      refine(square, inverse_, length_);
      return;
    }
#endif
    length_ = xsimd::sqrt(square);
  }
  [[nodiscard]] const Batch& length() const noexcept { return length_; }
  /// 0 where there is no length.
  [[nodiscard]] Batch inverse() const noexcept {
    if constexpr (estimated) { return inverse_; }
    const auto has_length = length_ > Batch(zero_length_);
    const Batch inverse = Batch(Real(1)) / length_;
    if constexpr (sizeof(has_length) == sizeof(Batch)) {
      return std::bit_cast<Batch>(has_length) & inverse;  // select() takes an instruction more
    } else {
      return xsimd::select(has_length, inverse, Batch(Real(0)));
    }
  }

 private:
  static constexpr bool estimated = fused::is_avx512<Arch>;
  Real zero_length_;
  Batch length_;
  Batch inverse_;  ///< known from the beginning where it is estimated
};

}  // namespace palpate
