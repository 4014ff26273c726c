// SPDX-License-Identifier: MIT
/// Kernels for the baseline of the build's architecture.

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

template <class Real> adjacency::Kernels<Real> adjacency::baseline_kernels() noexcept {
  return kernels_for<Real, Instructions>("baseline");
}
template adjacency::Kernels<double> adjacency::baseline_kernels<double>() noexcept;
template adjacency::Kernels<float> adjacency::baseline_kernels<float>() noexcept;

supernodes::Kernels supernodes::baseline_kernels() noexcept {
  return kernels_for<Instructions>("baseline");
}

}  // namespace palpate
