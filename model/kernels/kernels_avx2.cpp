// SPDX-License-Identifier: MIT
/// Kernels for AVX2 and FMA; called only on processors with both.

#include <type_traits>

#include "model/kernels/adjacency_kernel.hpp"
#include "model/kernels/lattice_kernel.hpp"
#include "model/kernels/supernode_kernel.hpp"

namespace palpate {

#if defined(__AVX2__)
using Instructions = xsimd::fma3<xsimd::avx2>;
/// Instruction set of the spring kernels with four lanes: eight lanes in float need more registers
/// than there are.
template <class Real>
using Fours = std::conditional_t<std::is_same_v<Real, double>, Instructions, xsimd::sse4_2>;
#else  // another architecture, where has_avx2() is false
using Instructions = xsimd::default_arch;
template <class Real> using Fours = Instructions;
#endif

template <class Real> lattice::Kernels<Real> lattice::avx2_kernels() noexcept {
  return kernels_for<Real, Instructions>("avx2");
}
template lattice::Kernels<double> lattice::avx2_kernels<double>() noexcept;
template lattice::Kernels<float> lattice::avx2_kernels<float>() noexcept;

template <class Real> adjacency::Kernels<Real> adjacency::avx2_kernels() noexcept {
  return kernels_for<Real, Fours<Real>>("avx2");
}
template adjacency::Kernels<double> adjacency::avx2_kernels<double>() noexcept;
template adjacency::Kernels<float> adjacency::avx2_kernels<float>() noexcept;

supernodes::Kernels supernodes::avx2_kernels() noexcept {
  return kernels_for<Instructions>("avx2");
}

}  // namespace palpate
