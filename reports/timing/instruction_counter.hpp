// SPDX-License-Identifier: MIT
#pragma once
/// Counts instructions with callgrind of Valgrind: this program runs itself under it, as `palpate steps`.

#include <atomic>
#include <string>
#include <vector>

#include "validation/timing/instruction_count.hpp"

namespace palpate::timing {

/// `words`: arguments of `palpate steps`. A machine without Valgrind, a program that does not run under it, an
/// interrupt: each is a refusal. Throws InputError for what the child refuses as bad input.
InstructionCount count_steps(const std::vector<std::string>& words, const std::atomic<bool>* stop);

/// Of workloads by name, two passes each.
InstructionCounter callgrind_counter(const std::atomic<bool>* stop);

}  // namespace palpate::timing
