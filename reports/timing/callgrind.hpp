// SPDX-License-Identifier: MIT
#pragma once
/// Reader for callgrind output: one file per part of a run. The Valgrind manual describes the
/// format in callgrind-format.html.

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
  std::string label{};    ///< set by the program; empty: part not requested by it
  std::int64_t instructions = 0;
};

/// Parses one part. Throws InputError with the file name if the file is truncated or counts events
/// other than instructions.
CallgrindPart part_from(const std::string& text, const std::string& file);

/// Returns the labelled parts in a folder, in the order in which the program requested them.
std::vector<CallgrindPart> labelled_parts(const std::filesystem::path& folder);

// Section of a program that a profiler measures.

/// Runs the work. Under `valgrind --tool=callgrind --instr-atstart=no` only its instructions are
/// counted, in a part with this label. Without Valgrind there is no overhead.
void run_counted(const std::string& label, const std::function<void()>& work);

// Instruction counts from Valgrind's callgrind. The program runs itself under Valgrind as `palpate
// steps`.

/// Counts the instructions of `palpate steps`. `words` are its arguments. Returns a refusal if
/// Valgrind is missing, if the program does not run under Valgrind, or after an interrupt. Throws
/// InputError if the child reports bad input.
InstructionCount count_steps(const std::vector<std::string>& words, const std::atomic<bool>* stop);

/// Instruction counter for named workloads; each workload is measured twice.
InstructionCounter callgrind_counter(const std::atomic<bool>* stop);

}  // namespace palpate::timing
