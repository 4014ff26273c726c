// SPDX-License-Identifier: MIT
/// What every processor of the build's architecture has.
#include "model/stepping/spring_fans_kernel.hpp"

namespace palpate::fans {

template <class Real>
Kernels<Real> baseline_kernels() noexcept {
  return kernels_for<Real, xsimd::default_arch>("baseline");
}
template Kernels<double> baseline_kernels<double>() noexcept;
template Kernels<float> baseline_kernels<float>() noexcept;

}  // namespace palpate::fans
