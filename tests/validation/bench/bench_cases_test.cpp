// SPDX-License-Identifier: MIT

#include "validation/bench/bench_cases.hpp"

#include "model/kernels/spring_kernels.hpp"
#include "tests/check.hpp"
#include "validation/gate/baseline.hpp"
#include "validation/gate/gate.hpp"

namespace PALPATE_FILE {

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

TEST("the same count twice passes, one instruction more does not, and no count is no verdict") {
  CHECK(found(passes(counted, counted)).status == Status::pass);
  CHECK(found(passes(counted, counted + 1)).status == Status::fail);
  const Outcome outcome = found({.refusal = "valgrind is not installed"});
  CHECK(outcome.status == Status::skip);
  CHECK(outcome.reason() == "not run: valgrind is not installed");
}

TEST("the gate accepts one per cent more instructions, but no other kernel and no missing count") {
  const auto times = [](std::int64_t thousandths) {
    return passes(counted * thousandths / 1000, counted * thousandths / 1000);
  };
  CHECK(against_accepted(times(1000)).identical);
  CHECK(!against_accepted(times(1009)).fails());
  CHECK(against_accepted(times(1011)).fails());
  CHECK(against_accepted(times(900)).better());
  CHECK(against_accepted({.refusal = "valgrind is not installed"}).fails());
  CHECK(against_accepted(passes(counted, counted, "another")).fails());
}

TEST("names of workloads are unique, and an unknown one is refused with the known ones") {
  std::vector<std::string> names;
  for (const Workload& each : workloads()) { names.push_back(each.name); }
  std::ranges::sort(names);
  CHECK(std::ranges::adjacent_find(names) == names.end());
  CHECK_THROWS(find_workload("cube"), "cube-list-double");
}

TEST("workloads run the kernels that they are named after") {
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

TEST("a build is slower by the clock only with more instructions or more missed deadlines") {
  const auto check_slower = [](const PairedFinding& finding, bool slower) {
    CHECK(is_slower(finding) == slower);
    CHECK(status_of(finding) == (slower ? Status::fail : Status::pass));
  };
  check_slower(finding_of(1.05, 1.05), true);
  check_slower(finding_of(1.05, 1.0), false);          // the machine, or the place of the code
  check_slower(finding_of(1.0, 1.05), false);          // the gate of counts judges these
  check_slower(finding_of(1.05, 1.0, 0.97e-3), true);  // misses deadlines
  PairedFinding uncounted = finding_of(1.05, 1.0);
  uncounted.head = {.refusal = "valgrind is not installed"};
  check_slower(uncounted, true);
}

TEST("the self-test fails with one missed slowdown or one alarm about equal builds") {
  const PairedFinding slower = finding_of(1.05, 1.05), equal = finding_of(1.0, 1.0);
  /// Status if the measurement number `wrong` returns `instead`.
  const auto status = [&](int wrong, const PairedFinding& instead) {
    int calls = 0;
    const auto measure = [&](const std::string&, Head head, std::uint64_t) {
      return ++calls == wrong ? instead : head == Head::planted ? slower : equal;
    };
    return run_case(self_test_cases({"s26"}, 20, measure).front(), {}).status;
  };
  CHECK(status(0, {}) == Status::pass);
  CHECK(status(30, equal) == Status::fail);
  CHECK(status(7, slower) == Status::fail);
}

}  // namespace PALPATE_FILE
