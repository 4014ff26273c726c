// SPDX-License-Identifier: MIT

#include "validation/gate/gate.hpp"

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "tests/check.hpp"
#include "tests/validation/planted_faults.hpp"
#include "validation/gate/baseline.hpp"
#include "validation/gate/change.hpp"

namespace {

using namespace palpate::gate;
using namespace palpate;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Quantity error_of(double value) {
  return {.name = "error", .value = value, .upper = 1e-3, .bound_from = "theory"};
}

ChangeKind judged(Quantity before, Quantity now, double spread = 0.0) {
  return compare_quantity(before, now, spread).kind;
}

TEST("the same bits need no allowance") {
  CHECK(judged(error_of(1e-6), error_of(1e-6)) == ChangeKind::same);
}

TEST("an error may lose a tenth of a digit and no more") {
  CHECK(judged(error_of(1e-6), error_of(1e-6 * std::pow(10.0, 0.099))) == ChangeKind::within);
  CHECK(judged(error_of(1e-6), error_of(1e-6 * std::pow(10.0, 0.101))) == ChangeKind::worse);
  CHECK(judged(error_of(1e-6), error_of(1e-6 / 2.0)) == ChangeKind::better);
}

TEST("an error that was nothing and is something is worse") {
  CHECK(judged(error_of(0.0), error_of(1e-15)) == ChangeKind::worse);
  CHECK(judged(error_of(1e-15), error_of(0.0)) == ChangeKind::better);
}

TEST("rounding is what it was measured to be, tenfold") {
  CHECK(judged(error_of(0.0), error_of(9e-16), 1e-16) == ChangeKind::rounding);
  CHECK(judged(error_of(0.0), error_of(2e-15), 1e-16) == ChangeKind::worse);
}

TEST("what is no number passes nowhere") {
  for (const double value : {nan, unbounded, -unbounded}) {
    CHECK(judged(error_of(1e-6), error_of(value), 1.0) == ChangeKind::broken);
  }
  CHECK(judged(error_of(nan), error_of(nan)) == ChangeKind::broken);
}

TEST("a value that should be large may not shrink") {
  Quantity before{.name = "digits agreed", .value = 10.0, .lower = 9.0, .bound_from = "theory"};
  Quantity now = before;
  now.value = 9.5;
  CHECK(judged(before, now) == ChangeKind::within);
  now.value = 20.0;
  CHECK(judged(before, now) == ChangeKind::better);
  before.value = 20.0;
  now.value = 12.0;
  CHECK(judged(before, now) == ChangeKind::worse);
}

TEST("between two bounds the middle is the truth, and a hundredth of the way is nothing") {
  Quantity before{
      .name = "order", .value = 2.0001, .lower = 1.85, .upper = 2.15, .bound_from = "theory"};
  Quantity now = before;
  now.value = 2.001;  // ten times as far, and still nothing
  CHECK(judged(before, now) == ChangeKind::within);
  now.value = 2.05;
  CHECK(judged(before, now) == ChangeKind::worse);
  now.value = 1.9999;
  CHECK(judged(before, now) == ChangeKind::within);
}

TEST("a number that no bound judges may move by one per cent either way") {
  const Quantity before{.name = "energy", .value = 2.0, .unit = "J"};
  Quantity now = before;
  now.value = 2.019;
  CHECK(judged(before, now) == ChangeKind::within);
  for (const double value : {2.021, 1.979, -2.0}) {
    now.value = value;
    CHECK(judged(before, now) == ChangeKind::moved);
  }
}

TEST("more work is worse, less is better, and digits are digits") {
  const Quantity work{.name = "tick", .value = 1e6, .unit = "instructions"};
  Quantity now = work;
  now.value = 1.0099e6;
  CHECK(judged(work, now) == ChangeKind::within);
  now.value = 1.0101e6;
  CHECK(judged(work, now) == ChangeKind::worse);
  now.value = 0.98e6;
  CHECK(judged(work, now) == ChangeKind::better);
  const Quantity digits{.name = "digits", .value = 3.0, .unit = "digits"};
  now = digits;
  now.value = 2.85;
  CHECK(judged(digits, now) == ChangeKind::worse);
  now.value = 2.95;
  CHECK(judged(digits, now) == ChangeKind::within);
}

TEST("another unit or another bound is another claim") {
  Quantity now = error_of(1e-6);
  now.unit = "mm";
  CHECK(judged(error_of(1e-6), now) == ChangeKind::broken);
  now = error_of(1e-6);
  now.upper = 2e-3;
  CHECK(judged(error_of(1e-6), now) == ChangeKind::broken);
}

TEST("a number that fell out of its bound is broken, whatever the allowance") {
  CHECK(judged(error_of(0.99e-3), error_of(1.01e-3)) == ChangeKind::broken);
}

Figure drawn(const std::function<double(double)>& law, int samples = 1001) {
  Series series{.label = "curve"};
  for (int n = 0; n < samples; ++n) {
    series.x.push_back(static_cast<double>(n) / (samples - 1));
    series.y.push_back(law(series.x.back()));
  }
  return {.id = "f", .x = {.label = "time (s)"}, .y = {.label = "force (N)"}, .series = {series}};
}

/// Pulse that is at rest at both ends.
double wave(double t) {
  const double angle = 2.0 * std::numbers::pi * t;
  return 1.0 - std::cos(angle) + 0.3 * (1.0 - std::cos(2.0 * angle));
}

/// Force that increases and becomes zero at time `at`.
double rupture(double t, double at) { return t < at ? 2.0 + t : 0.5 * t; }

ChangeKind judged(const Figure& before, const Figure& now, double spread = 0.0) {
  return compare_curve(before, now, 0, spread).kind;
}

TEST("a curve within the tube holds, one beside it does not") {
  const double range = 2.1;  // approximate range of wave()
  const Figure before = drawn(wave);
  CHECK(judged(before, before) == ChangeKind::same);
  CHECK(judged(before, drawn([&](double t) { return wave(t) + 1e-3 * range; })) ==
        ChangeKind::within);
  CHECK(judged(before, drawn([&](double t) { return wave(t) + 4e-3 * range; })) ==
        ChangeKind::moved);
}

TEST("one sample in a thousand that is off is seen") {
  Figure now = drawn(wave);
  now.series[0].y[500] += 0.1;
  CHECK(judged(drawn(wave), now) == ChangeKind::moved);
}

TEST("a spike that is gone is seen as well as one that came") {
  Figure before = drawn(wave);
  before.series[0].y[500] += 0.1;
  CHECK(judged(before, drawn(wave)) == ChangeKind::moved);
}

TEST("an event may come a tick early, and no earlier") {
  const auto at = [](double instant) {
    return drawn([instant](double t) { return rupture(t, instant); });
  };
  CHECK(judged(at(0.5), at(0.499)) == ChangeKind::within);
  CHECK(judged(at(0.5), at(0.495)) == ChangeKind::moved);
}

TEST("a whole curve that is one sample late is seen though every sample lies in the tube") {
  const auto late = [](double samples) {
    return drawn([samples](double t) { return wave(t - samples * 1e-3); });
  };
  const Change change = compare_curve(late(0.0), late(1.0), 0, 0.0);
  CHECK(change.kind == ChangeKind::moved);
  CHECK_CONTAINS(change.moved, "samples late");
  CHECK(judged(late(0.0), late(0.2)) == ChangeKind::within);
  CHECK_NEAR(lag_in_samples(late(0.0).series[0].x, late(0.0).series[0].y, late(0.3).series[0].y),
             0.3, 0.01);
}

TEST("a gain is no lag, and a ramp tells none") {
  const auto scaled = [](double gain) {
    return drawn([gain](double t) { return gain * wave(t); });
  };
  CHECK(std::isnan(
      lag_in_samples(scaled(1.0).series[0].x, scaled(1.0).series[0].y, scaled(1.001).series[0].y)));
  const auto ramp = [](double offset) { return drawn([offset](double t) { return t + offset; }); };
  CHECK(std::isnan(
      lag_in_samples(ramp(0.0).series[0].x, ramp(0.0).series[0].y, ramp(1e-3).series[0].y)));
}

TEST("what is not finite passes only where it stood before") {
  Figure gap = drawn(wave);
  gap.series[0].y[10] = nan;
  CHECK(judged(gap, gap) == ChangeKind::same);
  CHECK(judged(drawn(wave), gap) == ChangeKind::broken);
  CHECK(judged(gap, drawn(wave)) == ChangeKind::broken);
}

TEST("a curve of other length or name is another curve") {
  CHECK(judged(drawn(wave), drawn(wave, 1000)) == ChangeKind::broken);
  Figure now = drawn(wave);
  now.series[0].label = "other";
  CHECK(judged(drawn(wave), now) == ChangeKind::broken);
}

TEST("on a logarithmic axis errors have a tenth of a digit") {
  const auto errors = [](double factor) {
    Figure figure = drawn([factor](double x) { return factor * std::pow(10.0, -6.0 * x); }, 11);
    figure.y.logarithmic = true;
    return figure;
  };
  CHECK(judged(errors(1.0), errors(1.2)) == ChangeKind::within);
  CHECK(judged(errors(1.0), errors(1.3)) == ChangeKind::moved);
}

TEST("a constant has its own height for a range, and one of nothing has none") {
  const auto level = [](double y) { return drawn([y](double) { return y; }); };
  CHECK(judged(level(5.0), level(5.009)) == ChangeKind::within);
  CHECK(judged(level(5.0), level(5.011)) == ChangeKind::moved);
  CHECK(judged(level(0.0), level(1e-12)) == ChangeKind::moved);
  CHECK(judged(level(0.0), level(1e-16), 1e-16) == ChangeKind::rounding);
}

TEST("a small curve beside a large one is measured by the large one") {
  Figure before = drawn([](double t) { return 1e-9 * t; });
  before.series.push_back(drawn(wave).series[0]);
  Figure now = before;
  for (double& y : now.series[0].y) { y *= 1.5; }
  CHECK(judged(before, now) == ChangeKind::within);
}

TEST("both edges of a band are judged") {
  Figure before = drawn(wave);
  before.series[0].style = Series::Style::band;
  for (const double y : before.series[0].y) { before.series[0].y2.push_back(y + 1.0); }
  Figure now = before;
  now.series[0].y2[300] += 0.1;
  CHECK(judged(before, before) == ChangeKind::same);
  CHECK(judged(before, now) == ChangeKind::moved);
}

TEST("points are compared one by one, and one of many is not lost") {
  Figure before = drawn(wave);
  before.series[0].style = Series::Style::points;
  Figure now = before;
  now.series[0].y[700] += 0.1;
  CHECK(judged(before, now) == ChangeKind::moved);
}

// Properties that the cases of group "gate" do not cover: messages, approvals, and runs in another
// order.

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
  const GateResult verdict =
      compare(accepted({sample("a", 1e-5)}), {.command = "c", .outcomes = {sample("a", 1e-7)}});
  CHECK(verdict.holds());
  CHECK(verdict.counts().better == 1);
}

TEST("a case that becomes worse falls while others hold") {
  const Baseline baseline = accepted({sample("a", 1e-5), sample("b", 1e-5)});
  const GateResult verdict =
      compare(baseline, {.command = "c", .outcomes = {sample("a", 1e-5), sample("b", 9e-5)}});
  CHECK(!verdict.holds());
  CHECK(verdict.counts().identical == 1);
  CHECK(verdict.counts().failed == 1);
}

TEST("a selection looks at nothing else, and asks for no command") {
  const Baseline baseline = accepted({sample("a", 1e-5), sample("b", 1e-5)});
  const Candidate candidate{.command = "other", .outcomes = {sample("a", 1e-5)}};
  CHECK(!compare(baseline, candidate).holds());
  CHECK(compare(baseline, candidate, {"a"}).holds());
  CHECK(!compare(baseline, candidate, {"b"}).holds());
}

TEST("a case whose data were absent then may be judged now, and not the other way round") {
  Outcome skipped = sample("a", 1e-5);
  skipped.skip("no data");
  skipped.quantities.clear();
  CHECK(compare(accepted({skipped}), {.command = "c", .outcomes = {sample("a", 1e-5)}}).holds());
  CHECK(!compare(accepted({sample("a", 1e-5)}), {.command = "c", .outcomes = {skipped}}).holds());
}

TEST("of what is timed the counts alone are held, wall clocks never") {
  Outcome timed = sample("bench", 1e-5);
  timed.suite = "timing";
  timed.quantities = {{.name = "tick", .value = 1000.0, .unit = "instructions"},
                      {.name = "wall", .value = 5.0, .unit = "us"}};
  Outcome later = timed;
  later.quantities[1].value = 50.0;
  CHECK(compare(accepted({timed}), {.command = "c", .outcomes = {later}}).counts().identical == 1);
  later.quantities[0].value = 1020.0;
  CHECK(!compare(accepted({timed}), {.command = "c", .outcomes = {later}}).holds());
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
  REQUIRE(second.ledger.size() == 2);
  CHECK(second.ledger[1].cases == std::vector<std::string>{"a"});
}

TEST("a whole approval drops what is gone, and says so") {
  const Baseline first = accepted({sample("a", 1e-5), sample("b", 1e-5)});
  const Baseline second =
      accept(first, {.reason = "b is merged into a", .outcomes = {sample("a", 2e-5)}});
  CHECK(second.find("b") == nullptr);
  const std::vector<std::string> lines = described_changes(first, second);
  REQUIRE(lines.size() == 2);
  CHECK_CONTAINS(lines[0], "1e-05 -> 2e-05");
  CHECK_CONTAINS(lines[0], "bound -inf to 0.001");
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
  const Baseline baseline =
      accept({}, {.reason = "r",
                  .outcomes = {sample("a", 1e-5)},
                  .variants = {{sample("a", 1.25e-5)}, {sample("a", 0.5e-5)}}});
  CHECK_NEAR(baseline.cases[0].spread.quantities.at("error"), 0.5e-5, 1e-18);
  CHECK(baseline.cases[0].spread.runs == 2);
  CHECK_THROWS(
      accept({},
             {.reason = "r", .outcomes = {sample("a", 1e-5)}, .variants = {{sample("b", 1e-5)}}}),
      "is not in a variant");
}

TEST("damage turns the gate red") { check_status("gate/faults", nullptr, Status::pass); }

#ifndef PALPATE_SANITIZED  // two hundred runs of code that the damage tests also execute
TEST("the same code never turns it red") { check_status("gate/self", nullptr, Status::pass); }
#endif

}  // namespace
