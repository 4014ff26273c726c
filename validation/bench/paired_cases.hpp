// SPDX-License-Identifier: MIT
#pragma once
/// Two builds of the model against each other: wall clock in pairs, and instructions.

#include <functional>
#include <string>
#include <vector>

#include "validation/bench/bench_cases.hpp"
#include "validation/bench/timing.hpp"
#include "validation/case.hpp"

namespace palpate::bench {

/// What two builds take for one scene.
struct PairedFinding {
  std::vector<timing::PairedStart> starts{};
  bool same_motion = false;
  timing::InstructionCount base{};  ///< of the same ticks
  timing::InstructionCount head{};
};

/// Whose head is meant.
enum class Head { as_built, planted };

/// Measures a scene by its name; `seed`: of the order within pairs.
using PairedMeasurement =
    std::function<PairedFinding(const std::string& scene, Head head, std::uint64_t seed)>;

/// Whether the head is slower: the lower limit of the ratio of times is above 1.03, and it takes
/// more instructions or misses more deadlines. Where nobody counts instructions, the clock decides
/// alone.
bool is_slower(const PairedFinding& finding);

/// "bench/paired/SCENE": the head against the base.
std::vector<Case> paired_cases(const std::vector<std::string>& scenes,
                               const PairedMeasurement& measure);

/// "bench/self-test/SCENE": so many comparisons of a build with itself, and with itself slowed down
/// by one tick in twenty.
std::vector<Case> self_test_cases(const std::vector<std::string>& scenes, int comparisons,
                                  const PairedMeasurement& measure);

}  // namespace palpate::bench
