// SPDX-License-Identifier: MIT
#pragma once
/// Counts all allocations of the process and the allocated bytes. Include it in one source file of
/// a test. It requires glibc and does not work with sanitizers, which replace the allocator.

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <malloc.h>

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* block, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
void __libc_free(void* block);
}

namespace check {
inline std::atomic<long> allocations{0};
inline std::atomic<long> held_bytes{0};
inline std::atomic<long> most_held_bytes{0};  ///< peak since the last reset

inline void* taken(void* block) noexcept {
  ++allocations;
  const long held = held_bytes += static_cast<long>(malloc_usable_size(block));
  if (held > most_held_bytes) { most_held_bytes = held; }
  return block;
}
inline void give_back(void* block) noexcept {
  held_bytes -= static_cast<long>(malloc_usable_size(block));
}
}  // namespace check

// operator new calls one of these functions.
extern "C" {
void* malloc(std::size_t size) noexcept { return check::taken(__libc_malloc(size)); }
void* calloc(std::size_t count, std::size_t size) noexcept {
  return check::taken(__libc_calloc(count, size));
}
void* realloc(void* block, std::size_t size) noexcept {
  check::give_back(block);
  return check::taken(__libc_realloc(block, size));
}
void* memalign(std::size_t alignment, std::size_t size) noexcept {
  return check::taken(__libc_memalign(alignment, size));
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  return check::taken(__libc_memalign(alignment, size));
}
int posix_memalign(void** block, std::size_t alignment, std::size_t size) noexcept {
  *block = check::taken(__libc_memalign(alignment, size));
  return *block == nullptr ? ENOMEM : 0;
}
void free(void* block) noexcept {
  check::give_back(block);
  __libc_free(block);
}
}
