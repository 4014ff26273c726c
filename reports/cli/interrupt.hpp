// SPDX-License-Identifier: MIT
#pragma once
/// Ctrl-C: long work looks at this flag and ends with what is finished.

#include <atomic>

namespace palpate::cli {

/// Set by SIGINT and SIGTERM once catch_interrupts() was called, which is for commands that look at it; others end
/// at once, and so does every command that is asked twice.
extern std::atomic<bool> interrupted;
void catch_interrupts();

}  // namespace palpate::cli
