// SPDX-License-Identifier: MIT
#pragma once
/// Calls within a step cost up to a fifth of it. Sanitizers multiply code, so that there they are taken: else a file of
/// kernels would compile for minutes.

#if defined(PALPATE_SANITIZED)
#define PALPATE_ALWAYS_INLINE
#else
#define PALPATE_ALWAYS_INLINE __attribute__((always_inline))
#endif
