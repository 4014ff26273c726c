// SPDX-License-Identifier: MIT
#pragma once
/// Comparison of two builds of the model by wall clock in pairs and by instructions.

#include <functional>
#include <string>
#include <vector>

#include "validation/bench/bench_cases.hpp"
#include "validation/bench/timing.hpp"
#include "validation/case.hpp"

namespace palpate::bench {

/// Times and instruction counts of two builds for one scene.
struct PairedFinding {
  std::vector<timing::PairedStart> starts{};
  bool same_motion = false;
  timing::InstructionCount base{};  ///< instructions of the same ticks
  timing::InstructionCount head{};
};

/// Version of the head: as built, or slowed down deliberately.
enum class Head { as_built, planted };

/// Function that measures a scene by name; `seed` determines the order within pairs.
using PairedMeasurement =
    std::function<PairedFinding(const std::string& scene, Head head, std::uint64_t seed)>;

/// Returns true if the head is slower: the lower limit of the ratio of times is above 1.03, and it
/// executes more instructions or misses more deadlines. Without instruction counts the time decides
/// alone.
bool is_slower(const PairedFinding& finding);

/// Returns the cases "bench/paired/SCENE", which compare the head with the base.
std::vector<Case> paired_cases(const std::vector<std::string>& scenes,
                               const PairedMeasurement& measure);

/// Returns the cases "bench/self-test/SCENE": comparisons of a build with itself, and with itself
/// slowed down by one tick in twenty.
std::vector<Case> self_test_cases(const std::vector<std::string>& scenes, int comparisons,
                                  const PairedMeasurement& measure);

}  // namespace palpate::bench
