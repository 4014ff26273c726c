// SPDX-License-Identifier: MIT
#pragma once
/// Ctrl-C: long work looks at this flag and ends with what is finished.

#include <atomic>

namespace palpate::cli {

/// Set by SIGINT and SIGTERM once catch_interrupts() was called.
extern std::atomic<bool> interrupted;
void catch_interrupts();

}  // namespace palpate::cli
