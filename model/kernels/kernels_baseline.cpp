// SPDX-License-Identifier: MIT
/// Every kernel for what all processors of the build's architecture have.

#include "model/kernels/adjacency_kernel.hpp"
#include "model/kernels/lattice_kernel.hpp"
#include "model/kernels/supernode_kernel.hpp"

namespace palpate {

using Instructions = xsimd::default_arch;

template <class Real> lattice::Kernels<Real> lattice::baseline_kernels() noexcept {
  return kernels_for<Real, Instructions>("baseline");
}
template lattice::Kernels<double> lattice::baseline_kernels<double>() noexcept;
template lattice::Kernels<float> lattice::baseline_kernels<float>() noexcept;

template <class Real> fans::Kernels<Real> fans::baseline_kernels() noexcept {
  return kernels_for<Real, Instructions>("baseline");
}
template fans::Kernels<double> fans::baseline_kernels<double>() noexcept;
template fans::Kernels<float> fans::baseline_kernels<float>() noexcept;

panels::Kernels panels::baseline_kernels() noexcept {
  return kernels_for<Instructions>("baseline");
}

}  // namespace palpate
