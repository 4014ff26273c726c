// SPDX-License-Identifier: MIT
#pragma once
/// Instruction counts, which do not depend on other load of the machine.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "model/stepping/simulation.hpp"
#include "validation/bench/timing.hpp"
#include "validation/case.hpp"

namespace palpate::timing {

/// Machine instructions of the counted ticks of a workload.
struct InstructionCount {
  std::vector<std::int64_t> passes{};  ///< counts of identical passes, each with a new setup
  std::string kernel{};   ///< kernel chosen on the counting processor; it may differ from this one
  std::string counter{};  ///< "callgrind-3.19.0"
  std::string refusal{};  ///< why nothing was counted; empty if it was
};

/// Counts a workload by name twice. Does not throw; a machine that
/// cannot count gives a refusal.
using InstructionCounter = std::function<InstructionCount(const std::string& workload)>;

}  // namespace palpate::timing

namespace palpate::bench {

// Workloads for instruction counts: scenes small enough for a counter that runs fifty times slower,
// one for each kernel.

struct Workload {
  std::string name{};  ///< "cube-list-double"
  std::string what{};
  Scene scene{};
  bool as_list = false;  ///< same springs, but not detected as a regular lattice
  long before = 10;      ///< ticks before counting
  long ticks = 20;       ///< counted ticks
};

std::vector<Workload> workloads();

/// Returns a workload by name. Throws InputError that lists the valid names.
Workload find_workload(const std::string& name);

Simulation simulation_of(const Workload& workload);

/// Adds a very weak spring that is not part of a regular lattice, so that the list kernel is used.
void break_lattice(SpringNetwork& network);

// Cases of `palpate bench` (suite "timing"), which run one at a time.

std::vector<Case> kernel_cases();     ///< kernels, instruction sets, threads, skips
std::vector<Case> precision_cases();  ///< error against run time
std::vector<Case> needle_cases();     ///< stiff needle, reduced-order model
/// Processor time of every tick of a scene with a tool, the least of five runs, and the error of
/// the force against the same scene with every node, solved to rounding.
Case tick_case(const std::string& name, const Scene& scene);
std::vector<Case> frontier_cases();  ///< error against force evaluations
std::vector<Case> instruction_cases(const timing::InstructionCounter& counter);

/// Returns all cases in that order.
std::vector<Case> all_benches(const timing::InstructionCounter& counter);

// Comparison of two builds of the model by wall clock in pairs and by instructions.

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
