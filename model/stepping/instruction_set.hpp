// SPDX-License-Identifier: MIT
#pragma once
/// What the processor that we run on has beyond the baseline of its architecture.

namespace palpate {

inline bool has_avx2() noexcept {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
  return false;
#endif
}

}  // namespace palpate
