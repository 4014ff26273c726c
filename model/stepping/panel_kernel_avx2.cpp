// SPDX-License-Identifier: MIT
/// Compiled for AVX2 and FMA; called only where the processor has both.
#include "model/stepping/panel_kernel.hpp"

namespace palpate::panels {

Kernels avx2_kernels() noexcept { return kernels_for<xsimd::fma3<xsimd::avx2>>("avx2"); }

}  // namespace palpate::panels
