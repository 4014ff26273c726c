// SPDX-License-Identifier: MIT
#pragma once
/// Numbers below the normal range, which some processors take twenty times as long for.

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace palpate {

/// While it lives they count as zero on this thread, in what is read and in what comes out; afterwards they mean
/// what they did before. Below 2.2e-308 in double and 1.2e-38 in float: no tissue moves by so little.
class FlushedDenormals {
 public:
#if defined(__SSE2__)
  FlushedDenormals() noexcept : before_(_mm_getcsr()) { _mm_setcsr(before_ | flush_to_zero | denormals_are_zero); }
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

}  // namespace palpate
