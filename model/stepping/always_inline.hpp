// SPDX-License-Identifier: MIT
#pragma once
/// What a step goes through is inlined, whatever the compiler thinks of its size. Sanitizers multiply code, so that there
/// it takes calls: else a file of kernels would compile for minutes.

#if defined(PALPATE_SANITIZED)
#define PALPATE_ALWAYS_INLINE
#else
#define PALPATE_ALWAYS_INLINE __attribute__((always_inline))
#endif
