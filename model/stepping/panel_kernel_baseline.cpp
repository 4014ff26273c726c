// SPDX-License-Identifier: MIT
/// What every processor of the build's architecture has.
#include "model/stepping/panel_kernel.hpp"

namespace palpate::panels {

Kernels baseline_kernels() noexcept { return kernels_for<xsimd::default_arch>("baseline"); }

}  // namespace palpate::panels
