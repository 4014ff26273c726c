// SPDX-License-Identifier: MIT
#pragma once
/// Work that is counted instead of timed: the same number on a busy machine and on an idle one.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace palpate::timing {

/// Machine instructions of a workload's counted ticks.
struct InstructionCount {
  std::vector<std::int64_t> passes{};  ///< each set up anew and stepped alike
  std::string kernel{};                ///< that the counting processor chose; it may be another than this one
  std::string counter{};               ///< "callgrind-3.19.0"
  std::string refusal{};               ///< why nothing was counted; empty: it was
};

/// Counts a workload of that name (validation/bench/workloads.hpp), twice. Nothing is thrown where the machine
/// cannot: that is a refusal.
using InstructionCounter = std::function<InstructionCount(const std::string& workload)>;

}  // namespace palpate::timing
