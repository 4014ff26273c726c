// SPDX-License-Identifier: MIT
#include <algorithm>

#include "model/stepping/spring_fans.hpp"
#include "tests/check.hpp"
#include "validation/bench/bench_cases.hpp"
#include "validation/bench/workloads.hpp"
#include "validation/gate/baseline.hpp"
#include "validation/gate/gate.hpp"

namespace {

using namespace palpate;
using namespace palpate::bench;
using timing::InstructionCount;

constexpr std::int64_t counted = 10'000'000;

/// The first workload, found by a counter that says this.
Outcome found(const InstructionCount& count) {
  const std::vector<Case> cases = instruction_cases([&](const std::string&) { return count; });
  return run_case(cases.front(), {});
}

InstructionCount passes(std::int64_t first, std::int64_t second, const std::string& kernel = "k") {
  return {.passes = {first, second}, .kernel = kernel, .counter = "callgrind"};
}

gate::CaseVerdict against_accepted(const InstructionCount& now) {
  const Outcome accepted = found(passes(counted, counted));
  return gate::judge_case({.outcome = gate::comparable(accepted)}, gate::comparable(found(now)));
}

TEST("the same count twice passes; one instruction more does not") {
  CHECK(found(passes(counted, counted)).status == Status::pass);
  CHECK(found(passes(counted, counted + 1)).status == Status::fail);
}

TEST("where nobody counts nothing is judged, with the reason") {
  const Outcome outcome = found({.refusal = "valgrind is not installed"});
  CHECK(outcome.status == Status::skip && outcome.reason == "not run: valgrind is not installed");
}

TEST("the gate lets a count grow by one per cent, and no further") {
  CHECK(against_accepted(passes(counted, counted)).identical);
  CHECK(!against_accepted(passes(counted * 1009 / 1000, counted * 1009 / 1000)).falls());
  CHECK(against_accepted(passes(counted * 1011 / 1000, counted * 1011 / 1000)).falls());
  CHECK(against_accepted(passes(counted * 9 / 10, counted * 9 / 10)).better());
}

TEST("a count that is missing falls at the gate, and so does another kernel with the same count") {
  CHECK(against_accepted({.refusal = "valgrind is not installed"}).falls());
  CHECK(against_accepted(passes(counted, counted, "another")).falls());
}

TEST("names of workloads are unlike, and an unknown one is refused with those there are") {
  std::vector<std::string> names;
  for (const Workload& each : workloads()) { names.push_back(each.name); }
  std::ranges::sort(names);
  CHECK(std::ranges::adjacent_find(names) == names.end());
  try {
    (void)find_workload("cube");
    CHECK(false);
  } catch (const std::exception& error) {
    CHECK(std::string(error.what()).find("cube-list-double") != std::string::npos);
  }
}

TEST("workloads go through the kernels that they are named after") {
  const auto kernel = [](const char* name) { return simulation_of(find_workload(name)).plan().kernel; };
  CHECK(kernel("cube-list-double") == std::string("springs-damped-double-") + fan_kernels<double>().front().name);
  CHECK(kernel("cube-list-float") == std::string("springs-damped-float-") + fan_kernels<float>().front().name);
  CHECK(kernel("cube-lattice-double").starts_with("lattice-damped-double"));
  CHECK(kernel("cube-lattice-float").starts_with("lattice-damped-float"));
  CHECK(simulation_of(find_workload("needle-implicit")).plan().integrator->implicit);
  CHECK(!simulation_of(find_workload("needle-explicit")).plan().integrator->implicit);
}

}  // namespace
