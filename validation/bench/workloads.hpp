// SPDX-License-Identifier: MIT
#pragma once
/// What instructions are counted of: scenes small enough for a counter that runs fifty times slower, one for
/// each kernel.

#include <string>
#include <vector>

#include "model/stepping/simulation.hpp"

namespace palpate::bench {

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

/// Springs times substeps: how often a tick computes a spring, a scheme's further evaluations not counted.
double spring_steps_of_tick(const Simulation& simulation);

}  // namespace palpate::bench
