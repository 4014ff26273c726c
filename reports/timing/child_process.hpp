// SPDX-License-Identifier: MIT
#pragma once
/// Child processes: other programs or another instance of this program, run to completion.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "validation/bench/bench_cases.hpp"

namespace palpate::timing {

inline constexpr int bad_input = 2;  ///< exit code of `palpate` and of our scripts

/// Returns the first program with this name on PATH; empty if there is none.
std::filesystem::path find_program(const std::string& name);

/// Returns the path of the running executable.
std::filesystem::path own_program();

struct ChildEnd {
  int status = 0;  ///< exit code, or 128 plus the number of the terminating signal
  std::string output{};
  std::string errors{};
  bool stopped = false;  ///< true if the child was stopped because `stop` became true

  /// Last line of the child's standard error without its prefix, for error messages.
  [[nodiscard]] std::string last_words() const;
};

/// Runs a program. `words` is the path of the program, then its arguments. The child is terminated
/// when this process ends or when `stop` becomes true (nullptr: never); after `stop` the call
/// returns within about a third of a second. Throws std::runtime_error if the child cannot be
/// started.
ChildEnd run_child(const std::vector<std::string>& words, const std::atomic<bool>* stop);

/// Program that runs without output during the lifetime of the object.
class Background {
 public:
  explicit Background(const std::vector<std::string>& words);
  ~Background();
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

 private:
  int process_;
};

// Reader for callgrind output: one file per part of a run. The Valgrind manual describes the
// format in callgrind-format.html.

struct CallgrindPart {
  int number = 0;
  int thread = 1;         ///< 1: main thread
  std::string creator{};  ///< "callgrind-3.19.0"
  std::string label{};    ///< set by the program; empty: part not requested by it
  std::int64_t instructions = 0;
};

/// Parses one part. Throws InputError with the file name if the file is truncated or counts events
/// other than instructions.
CallgrindPart part_from(const std::string& text, const std::string& file);

/// Returns the labelled parts of the main thread in a folder, in the order in which the program
/// requested them.
std::vector<CallgrindPart> labelled_parts(const std::filesystem::path& folder);

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
