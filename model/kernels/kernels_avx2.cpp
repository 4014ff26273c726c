// SPDX-License-Identifier: MIT
/// Kernels for AVX2 and FMA; called only on processors with both.

#include "model/kernels/adjacency_kernel.hpp"
#include "model/kernels/cell_kernel.hpp"
#include "model/kernels/lattice_kernel.hpp"
#include "model/kernels/supernode_kernel.hpp"

namespace palpate {

#if defined(__AVX2__)
using Instructions = xsimd::fma3<xsimd::avx2>;
/// Instruction set of adjacency groups in float: eight lanes need more registers than there are.
using FloatFours = xsimd::sse4_2;
#else  // another architecture, where has_avx2() is false
using Instructions = xsimd::default_arch;
using FloatFours = Instructions;
#endif

KernelSet avx2_kernels() noexcept {
  return {.lattice_double = lattice::kernels_for<double, Instructions>("avx2"),
          .lattice_float = lattice::kernels_for<float, Instructions>("avx2"),
          .adjacency_double = adjacency::kernels_for<double, Instructions>("avx2"),
          .adjacency_float = adjacency::kernels_for<float, FloatFours>("avx2"),
          .supernodes = supernodes::kernels_for<Instructions>("avx2"),
          .cells_double = cells::kernels_for<double, Instructions>(),
          .cells_float = cells::kernels_for<float, Instructions>()};
}

}  // namespace palpate
