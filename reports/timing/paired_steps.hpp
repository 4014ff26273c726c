// SPDX-License-Identifier: MIT
#pragma once
/// Two step libraries in one process, timed in turn; and how its parent reads what it says.

#include <cstdint>
#include <filesystem>
#include <string>

#include "validation/timing/paired_times.hpp"

namespace palpate::timing {

struct PairedPlan {
  std::filesystem::path base{};
  std::filesystem::path head{};
  std::filesystem::path scene{};
  int pairs = 40;
  std::uint64_t seed = 1;   ///< of the order within pairs
  bool head_first = false;  ///< is loaded, and set up
  bool planted = false;     ///< the head takes one tick more in twenty: a slowdown that must be seen
};

/// Ticks of a batch are a whole multiple, so that a twentieth of them is a whole number.
inline constexpr long planted_every = 20;

struct PairedReport {
  PairedStart start{};
  bool same_motion = false;  ///< to the last bit, after as many ticks
};

/// Batches of half a millisecond at least; both scenes begin anew, outside the times, where they end. Throws
/// InputError for a scene of fewer than 20 ticks, and what LoadedLibrary throws.
PairedReport time_pairs(const PairedPlan& plan);

/// One line for each number, exact.
std::string to_text(const PairedReport& report);
/// Throws InputError when it is not what to_text() wrote.
PairedReport paired_report_from(const std::string& text);

}  // namespace palpate::timing
