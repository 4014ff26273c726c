// SPDX-License-Identifier: MIT
/// What the cases of group "gate" do not plant: who is told what, approvals, and runs in another order.
#include "validation/gate/gate.hpp"

#include "tests/check.hpp"
#include "tests/validation/planted_faults.hpp"
#include "validation/gate/approval.hpp"

namespace {

using namespace palpate;
using namespace palpate::gate;

Outcome sample(const std::string& name, double error) {
  Outcome outcome{.name = name, .suite = "accuracy", .claim = "It is right."};
  outcome.judge({.name = "error", .value = error, .upper = 1e-3, .bound_from = "theory"});
  conclude(outcome);
  return outcome;
}

Baseline accepted(const std::vector<Outcome>& outcomes) {
  return accept({}, {.command = "c", .date = "d", .reason = "first", .outcomes = outcomes});
}

TEST("better is told, holds, and asks for nothing more than an approval") {
  const Verdict verdict = judge(accepted({sample("a", 1e-5)}), {.command = "c", .outcomes = {sample("a", 1e-7)}});
  CHECK(verdict.holds());
  CHECK(verdict.tally().better == 1);
}

TEST("a case that becomes worse falls while others hold") {
  const Baseline baseline = accepted({sample("a", 1e-5), sample("b", 1e-5)});
  const Verdict verdict = judge(baseline, {.command = "c", .outcomes = {sample("a", 1e-5), sample("b", 9e-5)}});
  CHECK(!verdict.holds());
  CHECK(verdict.tally().identical == 1 && verdict.tally().fallen == 1);
}

TEST("a selection looks at nothing else, and asks for no command") {
  const Baseline baseline = accepted({sample("a", 1e-5), sample("b", 1e-5)});
  const Candidate candidate{.command = "other", .outcomes = {sample("a", 1e-5)}};
  CHECK(!judge(baseline, candidate).holds());
  CHECK(judge(baseline, candidate, {"a"}).holds());
  CHECK(!judge(baseline, candidate, {"b"}).holds());
}

TEST("a case whose data were absent then may be judged now, and not the other way round") {
  Outcome skipped = sample("a", 1e-5);
  skipped.skip("no data");
  skipped.quantities.clear();
  CHECK(judge(accepted({skipped}), {.command = "c", .outcomes = {sample("a", 1e-5)}}).holds());
  CHECK(!judge(accepted({sample("a", 1e-5)}), {.command = "c", .outcomes = {skipped}}).holds());
}

TEST("of what is timed the counts alone are held, wall clocks never") {
  Outcome timed = sample("bench", 1e-5);
  timed.suite = "timing";
  timed.quantities = {{.name = "tick", .value = 1000.0, .unit = "instructions"},
                      {.name = "wall", .value = 5.0, .unit = "us"}};
  Outcome later = timed;
  later.quantities[1].value = 50.0;
  CHECK(judge(accepted({timed}), {.command = "c", .outcomes = {later}}).tally().identical == 1);
  later.quantities[0].value = 1020.0;
  CHECK(!judge(accepted({timed}), {.command = "c", .outcomes = {later}}).holds());
}

TEST("a partial approval moves one case, and every approval is in the ledger") {
  const Baseline first = accepted({sample("a", 1e-5), sample("b", 1e-5)});
  const Baseline second = accept(first, {.command = "x",
                                         .date = "e",
                                         .reason = "a is another scheme now",
                                         .outcomes = {sample("a", 2e-5), sample("b", 3e-5)},
                                         .only = {"a"}});
  CHECK(second.find("a")->outcome.quantities[0].value == 2e-5);
  CHECK(second.find("b")->outcome.quantities[0].value == 1e-5);
  CHECK(second.command == "c");
  CHECK(second.ledger.size() == 2 && second.ledger[1].cases == std::vector<std::string>{"a"});
}

TEST("a whole approval drops what is gone, and says so") {
  const Baseline first = accepted({sample("a", 1e-5), sample("b", 1e-5)});
  const Baseline second = accept(first, {.reason = "b is merged into a", .outcomes = {sample("a", 2e-5)}});
  CHECK(second.find("b") == nullptr);
  const std::vector<std::string> lines = described_changes(first, second);
  CHECK(lines.size() == 2);
  CHECK(lines[0].find("1e-05 -> 2e-05") != std::string::npos && lines[0].find("bound -inf to 0.001") != std::string::npos);
  CHECK(lines[1] == "b: dropped");
}

TEST("errors and numbers that are none are not approved") {
  Outcome broken = sample("a", 1e-5);
  broken.status = Status::error;
  CHECK_THROWS(accepted({broken}), "ran to its end");
  CHECK_THROWS(accepted({sample("a", std::nan(""))}), "error is nan");
  CHECK_THROWS(accepted({}), "nothing to approve");
}

TEST("the spread is the largest difference that other builds showed") {
  const Baseline baseline = accept({}, {.reason = "r",
                                        .outcomes = {sample("a", 1e-5)},
                                        .variants = {{sample("a", 1.25e-5)}, {sample("a", 0.5e-5)}}});
  CHECK_NEAR(baseline.cases[0].spread.quantities.at("error"), 0.5e-5, 1e-18);
  CHECK(baseline.cases[0].spread.runs == 2);
  CHECK_THROWS(accept({}, {.reason = "r", .outcomes = {sample("a", 1e-5)}, .variants = {{sample("b", 1e-5)}}}),
               "is not in a variant");
}

TEST("damage turns the gate red") { check_status("gate/faults", nullptr, Status::pass); }

#ifndef PALPATE_SANITIZED  // two hundred runs of the same code, which those of damage go through too
TEST("the same code never turns it red") { check_status("gate/self", nullptr, Status::pass); }
#endif

}  // namespace
