// SPDX-License-Identifier: MIT
#include "validation/bench/paired_cases.hpp"

#include <algorithm>

#include "tests/check.hpp"

namespace {

using namespace palpate;
using namespace palpate::bench;

/// 240 pairs of that ratio, give or take one per cent; batches take `base` seconds and may take 1 ms.
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
  CHECK(is_slower(finding_of(1.05, 1.05)) && status_of(finding_of(1.05, 1.05)) == Status::fail);
}

TEST("slower by the clock alone is the machine, or where code lies") {
  CHECK(!is_slower(finding_of(1.05, 1.0)) && status_of(finding_of(1.05, 1.0)) == Status::pass);
}

TEST("more instructions that cost no time pass here; the gate of counts is for them") {
  CHECK(!is_slower(finding_of(1.0, 1.05)) && status_of(finding_of(1.0, 1.05)) == Status::pass);
}

TEST("slower by the clock with more missed deadlines falls, whatever is counted") {
  CHECK(is_slower(finding_of(1.05, 1.0, 0.97e-3)));
  CHECK(status_of(finding_of(1.05, 1.0, 0.97e-3)) == Status::fail);
}

TEST("where nobody counts the clock decides alone") {
  PairedFinding finding = finding_of(1.05, 1.0);
  finding.head = {.refusal = "valgrind is not installed"};
  CHECK(is_slower(finding) && status_of(finding) == Status::fail);
}

TEST("the self-test falls when a planted slowdown is missed once, or equal builds raise an alarm once") {
  int calls = 0;
  const auto status = [&](const PairedMeasurement& measure) {
    calls = 0;
    return run_case(self_test_cases({"s26"}, 20, measure).front(), {}).status;
  };
  const auto right = [&](Head head) { return head == Head::planted ? finding_of(1.05, 1.05) : finding_of(1.0, 1.0); };
  CHECK(status([&](const std::string&, Head head, std::uint64_t) { return right(head); }) == Status::pass);
  CHECK(status([&](const std::string&, Head head, std::uint64_t) {
          return ++calls == 30 ? finding_of(1.0, 1.0) : right(head);
        }) == Status::fail);
  CHECK(status([&](const std::string&, Head head, std::uint64_t) {
          return ++calls == 7 ? finding_of(1.05, 1.05) : right(head);
        }) == Status::fail);
}

}  // namespace
