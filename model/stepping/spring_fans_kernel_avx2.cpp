// SPDX-License-Identifier: MIT
/// Compiled for AVX2 and FMA; called only where the processor has both.
#include "model/stepping/spring_fans_kernel.hpp"

namespace palpate::fans {

template <class Real>
Kernels<Real> avx2_kernels() noexcept {
  return kernels_for<Real, xsimd::fma3<xsimd::avx2>>("avx2");
}
template Kernels<double> avx2_kernels<double>() noexcept;
template Kernels<float> avx2_kernels<float>() noexcept;

}  // namespace palpate::fans
