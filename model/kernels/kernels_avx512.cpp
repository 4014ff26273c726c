// SPDX-License-Identifier: MIT
/// Kernels for AVX-512; called only on processors with it.

#include "model/kernels/lattice_kernel.hpp"
#include "model/kernels/supernode_kernel.hpp"

namespace palpate {

#if defined(__AVX512DQ__)
using Instructions = xsimd::avx512f;
#else  // another architecture, where has_avx512() is false
using Instructions = xsimd::default_arch;
#endif

template <class Real> lattice::Kernels<Real> lattice::avx512_kernels() noexcept {
  return kernels_for<Real, Instructions>("avx512");
}
template lattice::Kernels<double> lattice::avx512_kernels<double>() noexcept;
template lattice::Kernels<float> lattice::avx512_kernels<float>() noexcept;

supernodes::Kernels supernodes::avx512_kernels() noexcept {
  return kernels_for<Instructions>("avx512");
}

}  // namespace palpate
