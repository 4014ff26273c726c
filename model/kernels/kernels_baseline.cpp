// SPDX-License-Identifier: MIT
/// Kernels for the baseline of the build's architecture.

#include "model/kernels/adjacency_kernel.hpp"
#include "model/kernels/cell_kernel.hpp"
#include "model/kernels/lattice_kernel.hpp"
#include "model/kernels/supernode_kernel.hpp"

namespace palpate {

KernelSet baseline_kernels() noexcept {
  using Instructions = xsimd::default_arch;
  // Adjacency groups in float have four lanes, also where the build allows wider ones.
  using FloatFours =
      std::conditional_t<(xsimd::batch<float>::size > 4), xsimd::sse4_2, Instructions>;
  return {.lattice_double = lattice::kernels_for<double, Instructions>("baseline"),
          .lattice_float = lattice::kernels_for<float, Instructions>("baseline"),
          .adjacency_double = adjacency::kernels_for<double, Instructions>("baseline"),
          .adjacency_float = adjacency::kernels_for<float, FloatFours>("baseline"),
          .supernodes = supernodes::kernels_for<Instructions>("baseline"),
          .cells_double = cells::kernels_for<double, Instructions>(),
          .cells_float = cells::kernels_for<float, Instructions>()};
}

}  // namespace palpate
