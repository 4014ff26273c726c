// SPDX-License-Identifier: MIT
#pragma once
/// How many of a fault's cases a test tries. The optimised build tries them all: verdicts are what
/// it is for. Under sanitizers, ten times slower, each fault is tried on its first two cases.

#include <algorithm>
#include <cstddef>
#include <span>

namespace palpate {

template <class Name>
std::span<const Name> tried(std::span<const Name> names) {
#ifdef PALPATE_SANITIZED
  return names.first(std::min<std::size_t>(2, names.size()));
#else
  return names;
#endif
}

}  // namespace palpate
