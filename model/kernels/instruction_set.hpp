// SPDX-License-Identifier: MIT
#pragma once
/// Flushing of denormal numbers, and the instruction sets of the processor.

#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "model/kernels/kernel_views.hpp"

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace palpate {

/// Flushes denormal operands and results to zero on this thread during the lifetime of the object:
/// arithmetic with denormals is much slower on some processors.
class FlushedDenormals {
 public:
#if defined(__SSE2__)
  FlushedDenormals() noexcept : before_(_mm_getcsr()) {
    _mm_setcsr(before_ | flush_to_zero | denormals_are_zero);
  }
  ~FlushedDenormals() { _mm_setcsr(before_); }
#else
  FlushedDenormals() noexcept = default;
  ~FlushedDenormals() {}
#endif
  FlushedDenormals(const FlushedDenormals&) = delete;
  FlushedDenormals& operator=(const FlushedDenormals&) = delete;

 private:
#if defined(__SSE2__)
  static constexpr unsigned flush_to_zero = 0x8000;
  static constexpr unsigned denormals_are_zero = 0x0040;
  unsigned before_;
#endif
};

inline bool has_avx2() noexcept {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
  return false;
#endif
}

/// Returns true if the processor has the parts of AVX-512 that the kernels use.
inline bool has_avx512() noexcept {
#if defined(__x86_64__)
  return has_avx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq");
#else
  return false;
#endif
}

enum class Widest { baseline, avx2, avx512 };

/// Returns the widest instruction set that the environment variable PALPATE_INSTRUCTIONS allows:
/// "avx512" (the default), "avx2" or "baseline". Throws std::invalid_argument for any other value.
inline Widest widest_allowed() {
  const char* asked = std::getenv("PALPATE_INSTRUCTIONS");
  const std::string_view name = asked == nullptr ? "avx512" : asked;
  if (name == "avx512") { return Widest::avx512; }
  if (name == "avx2") { return Widest::avx2; }
  if (name == "baseline") { return Widest::baseline; }
  throw std::invalid_argument("PALPATE_INSTRUCTIONS = " + std::string(name) +
                              "; must be avx512, avx2 or baseline");
}

/// Returns the kernels of one member that the processor supports and the environment allows, widest
/// first.
template <class Kernels> std::vector<Kernels> kernels_here(Kernels KernelSet::*member) {
  std::vector<Kernels> kernels;
  const Widest widest = widest_allowed();
  if (widest >= Widest::avx512 && has_avx512()) { kernels.push_back(avx512_kernels().*member); }
  if (widest >= Widest::avx2 && has_avx2()) { kernels.push_back(avx2_kernels().*member); }
  kernels.push_back(baseline_kernels().*member);
  std::erase_if(kernels, [](const Kernels& each) { return each.lanes == 0; });
  return kernels;
}

}  // namespace palpate
