// SPDX-License-Identifier: MIT
/// Kernels for AVX-512; called only on processors with it.

#include "model/kernels/cell_kernel.hpp"
#include "model/kernels/lattice_kernel.hpp"
#include "model/kernels/supernode_kernel.hpp"

namespace palpate {

#if defined(__AVX512DQ__)
using Instructions = xsimd::avx512f;
#else  // another architecture, where has_avx512() is false
using Instructions = xsimd::default_arch;
#endif

KernelSet avx512_kernels() noexcept {
  return {.lattice_double = lattice::kernels_for<double, Instructions>("avx512"),
          .lattice_float = lattice::kernels_for<float, Instructions>("avx512"),
          .supernodes = supernodes::kernels_for<Instructions>("avx512"),
          .cells_double = cells::kernels_for<double, Instructions>(),
          .cells_float = cells::kernels_for<float, Instructions>()};
}

}  // namespace palpate
