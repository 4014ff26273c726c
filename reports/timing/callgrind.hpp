// SPDX-License-Identifier: MIT
#pragma once
/// What callgrind writes: one file for each part of a run (the format's description is
/// callgrind-format.html of the Valgrind manual).

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "validation/bench/bench_cases.hpp"

namespace palpate::timing {

struct CallgrindPart {
  int number = 0;
  std::string creator{};  ///< "callgrind-3.19.0"
  std::string label{};    ///< that the program gave; empty: not asked for by the program
  std::int64_t instructions = 0;
};

/// Throws InputError, naming the file, when it is cut short or counts anything but instructions.
CallgrindPart part_from(const std::string& text, const std::string& file);

/// The parts in a folder that the program asked for, in that order.
std::vector<CallgrindPart> labelled_parts(const std::filesystem::path& folder);

// The stretch of a program that a profiler is to look at.

/// Does the work. Under `valgrind --tool=callgrind --instr-atstart=no` its instructions, and
/// nothing else, are counted into a part with that label (callgrind_output.hpp); without, it costs
/// nothing.
void run_counted(const std::string& label, const std::function<void()>& work);

// Counts instructions with callgrind of Valgrind: this program runs itself under it, as `palpate
// steps`.

/// `words`: arguments of `palpate steps`. A machine without Valgrind, a program that does not run
/// under it, an interrupt: each is a refusal. Throws InputError for what the child refuses as bad
/// input.
InstructionCount count_steps(const std::vector<std::string>& words, const std::atomic<bool>* stop);

/// Of workloads by name, two passes each.
InstructionCounter callgrind_counter(const std::atomic<bool>* stop);

}  // namespace palpate::timing
