// SPDX-License-Identifier: MIT

#include "validation/bench/bench_cases.hpp"

#include <algorithm>

#include "model/kernels/spring_kernels.hpp"
#include "tests/check.hpp"
#include "validation/bench/paired_cases.hpp"
#include "validation/gate/baseline.hpp"
#include "validation/gate/gate.hpp"

namespace {

using namespace palpate::bench;
using namespace palpate;
using timing::InstructionCount;

constexpr std::int64_t counted = 10'000'000;

/// Counter that returns the count of the first workload.
Outcome found(const InstructionCount& count) {
  const std::vector<Case> cases = instruction_cases([&](const std::string&) { return count; });
  return run_case(cases.front(), {});
}

InstructionCount passes(std::int64_t first, std::int64_t second, const std::string& kernel = "k") {
  return {.passes = {first, second}, .kernel = kernel, .counter = "callgrind"};
}

gate::CaseChanges against_accepted(const InstructionCount& now) {
  const Outcome accepted = found(passes(counted, counted));
  return gate::compare_case({.outcome = gate::comparable(accepted)}, gate::comparable(found(now)));
}

TEST("the same count twice passes; one instruction more does not") {
  CHECK(found(passes(counted, counted)).status == Status::pass);
  CHECK(found(passes(counted, counted + 1)).status == Status::fail);
}

TEST("where nobody counts nothing is judged, with the reason") {
  const Outcome outcome = found({.refusal = "valgrind is not installed"});
  CHECK(outcome.status == Status::skip);
  CHECK(outcome.reason() == "not run: valgrind is not installed");
}

TEST("the gate lets a count grow by one per cent, and no further") {
  CHECK(against_accepted(passes(counted, counted)).identical);
  CHECK(!against_accepted(passes(counted * 1009 / 1000, counted * 1009 / 1000)).fails());
  CHECK(against_accepted(passes(counted * 1011 / 1000, counted * 1011 / 1000)).fails());
  CHECK(against_accepted(passes(counted * 9 / 10, counted * 9 / 10)).better());
}

TEST("a count that is missing falls at the gate, and so does another kernel with the same count") {
  CHECK(against_accepted({.refusal = "valgrind is not installed"}).fails());
  CHECK(against_accepted(passes(counted, counted, "another")).fails());
}

TEST("names of workloads are unlike, and an unknown one is refused with those there are") {
  std::vector<std::string> names;
  for (const Workload& each : workloads()) { names.push_back(each.name); }
  std::ranges::sort(names);
  CHECK(std::ranges::adjacent_find(names) == names.end());
  try {
    (void)find_workload("cube");
    CHECK(false);
  } catch (const std::exception& error) { CHECK_CONTAINS(error.what(), "cube-list-double"); }
}

TEST("workloads go through the kernels that they are named after") {
  const auto kernel = [](const char* name) {
    return simulation_of(find_workload(name)).plan().kernel;
  };
  CHECK(kernel("cube-list-double") ==
        std::string("springs-damped-double-") + adjacency_kernels<double>().front().name);
  CHECK(kernel("cube-list-float") ==
        std::string("springs-damped-float-") + adjacency_kernels<float>().front().name);
  CHECK(kernel("cube-lattice-double").starts_with("lattice-damped-double"));
  CHECK(kernel("cube-lattice-float").starts_with("lattice-damped-float"));
  CHECK(simulation_of(find_workload("needle-implicit")).plan().integrator->implicit);
  CHECK(!simulation_of(find_workload("needle-explicit")).plan().integrator->implicit);
}

/// 240 pairs with that ratio, +-1 %; batches take `base` seconds, with up to 1 ms added.
PairedFinding finding_of(double ratio, double instructions, double base = 5e-4) {
  PairedFinding finding{.same_motion = true, .base = {.passes = {100000}}, .head = {}};
  finding.head.passes = {static_cast<std::int64_t>(100000.0 * instructions)};
  for (int start = 0; start < 6; ++start) {
    timing::PairedStart& pairs = finding.starts.emplace_back();
    pairs.batch_deadline = 1e-3;
    for (int n = 0; n < 40; ++n) {
      const double head = base * ratio * (0.99 + 0.0005 * n);
      pairs.pairs.push_back({base, head, base, head});
    }
  }
  return finding;
}

Status status_of(const PairedFinding& finding) {
  const auto measure = [&](const std::string&, Head, std::uint64_t) { return finding; };
  return run_case(paired_cases({"s26"}, measure).front(), {}).status;
}

TEST("slower by the clock and by instructions falls") {
  CHECK(is_slower(finding_of(1.05, 1.05)));
  CHECK(status_of(finding_of(1.05, 1.05)) == Status::fail);
}

TEST("slower by the clock alone is the machine, or where code lies") {
  CHECK(!is_slower(finding_of(1.05, 1.0)));
  CHECK(status_of(finding_of(1.05, 1.0)) == Status::pass);
}

TEST("more instructions that cost no time pass here; the gate of counts is for them") {
  CHECK(!is_slower(finding_of(1.0, 1.05)));
  CHECK(status_of(finding_of(1.0, 1.05)) == Status::pass);
}

TEST("slower by the clock with more missed deadlines falls, whatever is counted") {
  CHECK(is_slower(finding_of(1.05, 1.0, 0.97e-3)));
  CHECK(status_of(finding_of(1.05, 1.0, 0.97e-3)) == Status::fail);
}

TEST("where nobody counts the clock decides alone") {
  PairedFinding finding = finding_of(1.05, 1.0);
  finding.head = {.refusal = "valgrind is not installed"};
  CHECK(is_slower(finding));
  CHECK(status_of(finding) == Status::fail);
}

TEST(
    "the self-test falls when a planted slowdown is missed once, or equal builds raise an alarm "
    "once") {
  int calls = 0;
  const auto status = [&](const PairedMeasurement& measure) {
    calls = 0;
    return run_case(self_test_cases({"s26"}, 20, measure).front(), {}).status;
  };
  const auto right = [&](Head head) {
    return head == Head::planted ? finding_of(1.05, 1.05) : finding_of(1.0, 1.0);
  };
  CHECK(status([&](const std::string&, Head head, std::uint64_t) { return right(head); }) ==
        Status::pass);
  CHECK(status([&](const std::string&, Head head, std::uint64_t) {
          return ++calls == 30 ? finding_of(1.0, 1.0) : right(head);
        }) == Status::fail);
  CHECK(status([&](const std::string&, Head head, std::uint64_t) {
          return ++calls == 7 ? finding_of(1.05, 1.05) : right(head);
        }) == Status::fail);
}

}  // namespace
