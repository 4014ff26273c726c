// SPDX-License-Identifier: MIT
#pragma once
/// Work that is counted instead of timed: the same number on a busy machine and on an idle one.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "model/stepping/simulation.hpp"
#include "validation/case.hpp"

namespace palpate::timing {

/// Machine instructions of a workload's counted ticks.
struct InstructionCount {
  std::vector<std::int64_t> passes{};  ///< each set up anew and stepped alike
  std::string kernel{};   ///< that the counting processor chose; it may be another than this one
  std::string counter{};  ///< "callgrind-3.19.0"
  std::string refusal{};  ///< why nothing was counted; empty: it was
};

/// Counts a workload of that name (validation/bench/workloads.hpp), twice. Nothing is thrown where
/// the machine cannot: that is a refusal.
using InstructionCounter = std::function<InstructionCount(const std::string& workload)>;

}  // namespace palpate::timing

namespace palpate::bench {

// What instructions are counted of: scenes small enough for a counter that runs fifty times slower,
// one for each kernel.

struct Workload {
  std::string name{};  ///< "cube-list-double"
  std::string what{};
  Scene scene{};
  bool as_list = false;  ///< the same springs, but not known to be a regular lattice
  long before = 10;      ///< ticks that are not counted
  long ticks = 20;       ///< that are
};

std::vector<Workload> workloads();

/// Throws InputError, naming those there are.
Workload find_workload(const std::string& name);

Simulation simulation_of(const Workload& workload);

/// Springs times substeps: how often a tick computes a spring, a scheme's further evaluations not
/// counted.
double spring_steps_of_tick(const Simulation& simulation);

// What `palpate bench` measures: cases of the suite "timing", which run one at a time.

std::vector<Case> kernel_cases();
std::vector<Case> instruction_set_cases();
std::vector<Case> thread_cases();
std::vector<Case> skip_cases();
std::vector<Case> precision_cases();
std::vector<Case> needle_cases();
std::vector<Case> far_field_cases();
std::vector<Case> frontier_cases();
std::vector<Case> instruction_cases(const timing::InstructionCounter& counter);

/// Every one, in that order.
std::vector<Case> all_benches(const timing::InstructionCounter& counter);

/// The problem that mass-spring programs are compared with: n x n x n nodes of 1 g, 10 mm apart, 26
/// neighbours with 50 N/m and 0.05 N s/m, one face held, 0.1 N on the middle of the other.
Scene s26_scene(int n);

}  // namespace palpate::bench
