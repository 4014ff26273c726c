// SPDX-License-Identifier: MIT

#include "validation/gate/gate.hpp"

#include <functional>
#include <numbers>

#include "tests/validation/planted_faults.hpp"

namespace PALPATE_FILE {

using namespace palpate::gate;
using namespace palpate;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST("a quantity may move by the allowance of its kind, and not out of its bound") {
  const Quantity error{.name = "error", .upper = 1e-3, .bound_from = "theory"};
  // A value that should be large may not shrink.
  const Quantity large{.name = "digits agreed", .lower = 9.0, .bound_from = "theory"};
  // Between two bounds the middle is the truth, and a hundredth of the way is nothing.
  const Quantity order{.name = "order", .lower = 1.85, .upper = 2.15, .bound_from = "theory"};
  const Quantity free{.name = "energy", .unit = "J"};
  const Quantity force{.name = "lateral force", .unit = "N"};
  const Quantity event{.name = "event: contact", .unit = "s", .uncertainty = 2e-3};
  const Quantity failures{.name = "failures", .upper = 5.0, .bound_from = "theory"};
  const Quantity work{.name = "tick", .unit = "instructions"};
  const Quantity digits{.name = "digits", .unit = "digits"};
  using enum ChangeKind;
  struct {
    Quantity quantity;
    double before, now;
    ChangeKind kind;
    double spread = 0.0;
  } const rows[] = {
      {error, 1e-6, 1e-6, same},
      {error, 1e-6, 1e-6 * std::pow(10.0, 0.099), within},  // a tenth of a digit
      {error, 1e-6, 1e-6 * std::pow(10.0, 0.101), worse},
      {error, 1e-6, 1e-6 / 2.0, better},
      {error, 0.0, 0.9e-13, rounding},  // the floor of the unit
      {error, 0.0, 1.1e-13, worse},
      {error, 1e-15, 0.0, rounding},
      {error, 0.0, 9e-12, rounding, 1e-12},  // ten times the measured rounding
      {error, 0.0, 1.1e-11, worse, 1e-12},
      {error, 1e-6, 0.0, broken},  // vanished
      {error, 1e-6, 1e-14, broken},
      {error, 0.9e-10, 1e-14, better},  // less than a thousand floors
      {failures, 3.0, 0.0, better},     // a count may
      {error, 1e-6, nan, broken, 1.0},
      {error, 1e-6, unbounded, broken, 1.0},
      {error, 1e-6, -unbounded, broken, 1.0},
      {error, nan, nan, broken},
      {error, 0.99e-3, 1.01e-3, broken},
      {large, 10.0, 9.5, within},
      {large, 10.0, 20.0, better},
      {large, 20.0, 12.0, worse},
      {order, 2.0001, 2.001, within},  // ten times as far, and still nothing
      {order, 2.0001, 2.05, worse},
      {order, 2.0001, 1.9999, within},
      {free, 2.0, 2.019, within},  // one per cent either way
      {free, 2.0, 2.021, moved},
      {free, 2.0, 1.979, moved},
      {free, 2.0, -2.0, moved},
      {force, 0.0, 0.9e-9, rounding},
      {force, 0.0, 1.1e-9, moved},
      {event, 1.0, 1.0019, within},  // two ticks
      {event, 1.0, 1.0021, moved},
      {event, 1.0, 1.0029, within, 1e-3},  // and the spread, once
      {event, 1.0, 1.0031, moved, 1e-3},
      {work, 1e6, 1.0099e6, within},
      {work, 1e6, 1.0101e6, worse},
      {work, 1e6, 0.98e6, better},
      {digits, 3.0, 2.85, worse},
      {digits, 3.0, 2.95, within},
  };
  for (const auto& row : rows) {
    Quantity before = row.quantity;
    Quantity now = row.quantity;
    before.value = row.before;
    now.value = row.now;
    const ChangeKind kind = compare_quantity(before, now, row.spread).kind;
    check::row = now.name + " " + check::shown(before.value) + " " + check::shown(now.value);
    CHECK(kind == row.kind);
  }
  // Another unit or another bound is another claim.
  Quantity before = error;
  before.value = 1e-6;
  Quantity other_unit = before, other_bound = before;
  other_unit.unit = "mm";
  other_bound.upper = 2e-3;
  for (const Quantity& now : {other_unit, other_bound}) {
    CHECK(compare_quantity(before, now, 0.0).kind == broken);
  }
}

using Law = std::function<double(double)>;

Figure drawn(const Law& law, int samples = 1001) {
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

Figure wave_late(double samples) {
  return drawn([samples](double t) { return wave(t - samples * 1e-3); });
}

/// Force that increases and becomes lower at time `at`.
Figure rupture(double at) {
  return drawn([at](double t) { return t < at ? 2.0 + t : 0.5 * t; });
}

Figure level(double y) {
  return drawn([y](double) { return y; });
}

/// Wave with one sample changed.
Figure spiked(std::size_t sample, double by, Series::Style style = Series::Style::line) {
  Figure figure = drawn(wave);
  figure.series[0].style = style;
  figure.series[0].y[sample] += by;
  return figure;
}

/// Errors on a logarithmic axis.
Figure errors(double factor) {
  Figure figure = drawn([factor](double x) { return factor * std::pow(10.0, -6.0 * x); }, 11);
  figure.y.logarithmic = true;
  return figure;
}

/// Small relative errors on a logarithmic axis.
Figure ratios(double level) {
  Figure figure = drawn([level](double x) { return level * (1.0 + x); }, 11);
  figure.y = {.label = "largest error / peak", .logarithmic = true};
  return figure;
}

/// Band above the wave, of which one sample of the upper edge is changed.
Figure band(double by) {
  Figure figure = drawn(wave);
  figure.series[0].style = Series::Style::band;
  for (const double y : figure.series[0].y) { figure.series[0].y2.push_back(y + 1.0); }
  figure.series[0].y2[300] += by;
  return figure;
}

/// Rupture in a curve of ten seconds at 1 kHz.
Figure long_rupture(double at) {
  Figure figure = drawn([at](double t) { return 10.0 * t < at ? 2.0 + t : 0.5 * t; }, 10001);
  for (double& x : figure.series[0].x) { x *= 10.0; }
  return figure;
}

/// Small curve beside the wave.
Figure small_beside_large(double factor) {
  Figure figure = drawn([factor](double t) { return factor * 1e-6 * t; });
  figure.series.push_back(drawn(wave).series[0]);
  return figure;
}

TEST("a curve passes within the tube around its baseline and is moved outside it") {
  const Figure before = drawn(wave);
  const auto higher = [](double share) {  // of the approximate range of wave()
    return drawn([share](double t) { return wave(t) + share * 2.1; });
  };
  const Figure gap = spiked(10, nan);
  const Figure points = spiked(0, 0.0, Series::Style::points);
  Figure other_name = before;
  other_name.series[0].label = "other";
  using enum ChangeKind;
  struct {
    const char* what;
    Figure before, now;
    ChangeKind kind;
    double spread = 0.0;
  } const rows[] = {
      {"same", before, before, same},
      {"in the tube", before, higher(1e-3), within},
      {"beside the tube", before, higher(4e-3), moved},
      {"one sample in a thousand", before, spiked(500, 0.1), moved},
      {"spike that disappeared", spiked(500, 0.1), before, moved},
      {"event one tick early", rupture(0.5), rupture(0.499), within},
      {"event five ticks early", rupture(0.5), rupture(0.495), moved},
      {"one sample late, each sample in the tube", wave_late(0.0), wave_late(1.0), moved},
      {"a fifth of a sample late", wave_late(0.0), wave_late(0.2), within},
      {"gap in both", gap, gap, same},
      {"gap now", before, gap, broken},
      {"gap before", gap, before, broken},
      {"another length", before, drawn(wave, 1000), broken},
      {"another name", before, other_name, broken},
      {"errors within a tenth of a digit", errors(1.0), errors(1.2), within},
      {"errors beyond a tenth of a digit", errors(1.0), errors(1.3), moved},
      {"constant, whose range is its height", level(5.0), level(5.009), within},
      {"constant beyond it", level(5.0), level(5.011), moved},
      {"event two ticks of ten seconds early", long_rupture(5.0), long_rupture(4.998), within},
      {"event three ticks of ten seconds early", long_rupture(5.0), long_rupture(4.997), moved},
      {"below the floor", level(0.0), drawn([](double t) { return 0.9e-9 * t; }), rounding},
      {"above the floor", drawn([](double t) { return 0.9e-9 * t; }),
       drawn([](double t) { return 2e-9 * t; }), moved},
      {"errors below the floor of a ratio", ratios(1e-17), ratios(1e-14), rounding},
      {"errors that reach the floor", ratios(1e-14), ratios(2e-13), moved},
      {"rounding of zero", level(0.0), level(9e-9), rounding, 1e-9},
      {"range of the larger curve", small_beside_large(1.0), small_beside_large(1.5), within},
      {"same band", band(0.0), band(0.0), same},
      {"upper edge of a band", band(0.0), band(0.1), moved},
      {"one point of many", points, spiked(700, 0.1, Series::Style::points), moved},
  };
  for (const auto& row : rows) {
    const ChangeKind kind = compare_curve(row.before, row.now, 0, row.spread).kind;
    check::row = row.what;
    CHECK(kind == row.kind);
  }
  CHECK_CONTAINS(compare_curve(wave_late(0.0), wave_late(1.0), 0, 0.0).moved, "samples late");
}

TEST("a lag is measured, a gain is no lag, and a ramp has none") {
  const auto lag = [](const Figure& before, const Figure& now) {
    return lag_in_samples(before.series[0].x, before.series[0].y, now.series[0].y);
  };
  CHECK_NEAR(lag(wave_late(0.0), wave_late(0.3)), 0.3, 0.01);
  CHECK(std::isnan(lag(drawn(wave), drawn([](double t) { return 1.001 * wave(t); }))));
  CHECK(
      std::isnan(lag(drawn([](double t) { return t; }), drawn([](double t) { return t + 1e-3; }))));
}

// Properties that the cases of group "gate" do not cover: messages, approvals, and runs in another
// order.

Outcome sample(const std::string& name, double error) {
  Outcome outcome{.name = name, .suite = "accuracy", .claim = "It is right."};
  outcome.judge({.name = "error", .value = error, .upper = 1e-3, .bound_from = "theory"});
  conclude(outcome);
  return outcome;
}

using Outcomes = std::vector<Outcome>;
const Outcomes pair{sample("a", 1e-5), sample("b", 1e-5)};

Baseline accepted(const Outcomes& outcomes) {
  return accept({}, {.command = "c", .date = "d", .reason = "first", .outcomes = outcomes});
}

GateResult compared(const Outcomes& before, const Outcomes& now) {
  return compare(accepted(before), {.command = "c", .outcomes = now});
}

TEST("a case that becomes worse fails while others pass, and a better one passes") {
  const GateResult better = compared({sample("a", 1e-5)}, {sample("a", 1e-7)});
  CHECK(better.holds());
  CHECK(better.counts().better == 1);
  const GateResult worse = compared(pair, {sample("a", 1e-5), sample("b", 9e-5)});
  CHECK(!worse.holds());
  CHECK(worse.counts().identical == 1);
  CHECK(worse.counts().failed == 1);
}

TEST("a selection compares nothing else, and may come from a run of it alone") {
  const Baseline all = accept(
      {},
      {.command = "palpate validate --quick", .date = "d", .reason = "first", .outcomes = pair});
  const Candidate alone{.command = "palpate validate a --quick", .outcomes = {sample("a", 1e-5)}};
  CHECK(!compare(all, alone).holds());
  CHECK(compare(all, alone, {"a"}).holds());
  CHECK(!compare(all, alone, {"b"}).holds());
  const Candidate whole{.command = "palpate validate a", .outcomes = {sample("a", 1e-5)}};
  CHECK(!compare(all, whole, {"a"}).holds());  // not the short form
  CHECK_THROWS(accept(all, {.command = whole.command,
                            .date = "e",
                            .reason = "r",
                            .outcomes = whole.outcomes,
                            .only = {"a"}}),
               "results of `palpate validate a`, the baseline has those of");
}

TEST("command lines agree in any order of cases, and without options that change no verdict") {
  const std::string accepted = "palpate validate a b/c --quick --order 3";
  for (const char* same :
       {"palpate validate a b/c --quick --order 3", "palpate validate b/c a --quick --order 3",
        "palpate validate a b/c a --quick --order 3",
        "palpate validate a b/c --quick --order 3 --subject-options {} --in-process "
        "--subject-time-limit 9",
        "palpate validate a b/c --quick --no-skip --order 3 --seed 5",
        "palpate validate a b/c --quick --order 3 --subject model"}) {
    CHECK(command_problem(accepted, same, false).empty());
  }
  const std::string with_library = accepted + " --subject build/simulator.so";
  CHECK(command_problem(with_library, accepted + " --subject /tmp/simulator.so", false).empty());
  CHECK(!command_problem(with_library, accepted + " --subject build/other.so", false).empty());
  const std::string with_command = accepted + " --subject 'exec:python3 a/sim.py'";
  CHECK(command_problem(with_command + " --expected known.toml --subject-options '{\"a\":1}'",
                        accepted + " --subject 'exec:python3 /b/sim.py' --expected /c/known.toml "
                                   "--subject-options '{\"a\": 1}' --subject-memory-limit 99",
                        false)
            .empty());
  CHECK(!command_problem(with_command, accepted + " --subject 'exec:python3 a/other.py'", false)
             .empty());
  CHECK(!command_problem(with_command + " --subject-options '{\"a b\":1}'",
                         with_command + " --subject-options '{\"ab\":1}'", false)
             .empty());
  for (const char* other :
       {"palpate bench a b/c --quick --order 3", "palpate validate a b/c --order 3",
        "palpate validate a b/c --quick --order 4",
        "palpate validate a b/c --quick --order 3 --subject exec:x",
        "palpate validate a --quick --order 3"}) {
    CHECK(!command_problem(accepted, other, false).empty());
  }
  CHECK(command_problem(accepted, "palpate validate a --quick --order 3", true).empty());
  CHECK(!command_problem(accepted, "palpate bench a --quick --order 3", true).empty());
}

TEST("a command is split as a shell does") {
  const std::vector<std::string> words =
      shell_words(R"(exec:sh  'my sim.py' "it's" 'it'\''s' a\ b '' -c)");
  const std::vector<std::string> expected{"exec:sh", "my sim.py", "it's", "it's", "a b", "", "-c"};
  CHECK(words == expected);
}

TEST("the axes of a map are compared, and a changed origin of a bound is named") {
  Outcome map = sample("a", 1e-5);
  map.figures.push_back(
      {.id = "map",
       .heat_map = HeatMap{
           .label = "stiffness", .x = {0.0, 0.01}, .y = {0.0, 0.02}, .z = {1e4, 2e4, 3e4, 4e4}}});
  CHECK(compared({map}, {map}).counts().identical == 1);
  for (std::vector<double> HeatMap::*axis : {&HeatMap::x, &HeatMap::y}) {
    Outcome moved = map;
    ((*moved.figures.back().heat_map).*axis)[1] *= 1.1;
    CHECK(!compared({map}, {moved}).holds());
  }
  Outcome other = sample("a", 1e-5);
  other.quantities[0].bound_from = "another theory";
  const GateResult named = compared({sample("a", 1e-5)}, {other});
  CHECK(named.holds());
  CHECK(named.counts().identical == 0);
  REQUIRE(named.cases[0].changes.size() == 1);
  CHECK_CONTAINS(named.cases[0].changes[0].moved, "bound from \"another theory\", was");
}

TEST("a larger uncertainty in one of the files does not hide that an event moved") {
  const auto at = [](double time, double uncertainty) {
    Outcome outcome{.name = "run", .suite = "run", .claim = "A scene"};
    outcome.quantities.push_back(
        {.name = "event: puncture", .value = time, .unit = "s", .uncertainty = uncertainty});
    outcome.status = Status::pass;
    return outcome;
  };
  CHECK(compared({at(1.0, 2e-3)}, {at(1.001, 2e-3)}).holds());
  CHECK(!compared({at(1.0, 2e-3)}, {at(6.0, 2e-3)}).holds());
  CHECK(!compared({at(1.0, 1e9)}, {at(6.0, 2e-3)}).holds());
  CHECK(!compared({at(1.0, 2e-3)}, {at(6.0, 1e9)}).holds());
}

TEST("a case of another suite fails: the wall clocks of suite timing are not compared") {
  Outcome other = sample("a", 1e-5);
  other.suite = "timing";
  const GateResult moved = compared({sample("a", 1e-5)}, {other});
  CHECK(!moved.holds());
  CHECK_CONTAINS(moved.cases[0].outcome.reason(), "suite is \"timing\", was \"accuracy\"");
}

TEST("an inconclusive case does not pass by a smaller uncertainty") {
  const auto with = [](double uncertainty) {
    Outcome outcome{.name = "a", .suite = "accuracy", .claim = "It is right."};
    outcome.judge({.name = "error",
                   .value = 1e-3,
                   .upper = 1.1e-3,
                   .bound_from = "theory",
                   .uncertainty = uncertainty});
    conclude(outcome);
    return outcome;
  };
  CHECK(with(2e-4).status == Status::inconclusive);
  const Baseline baseline = accept(
      {},
      {.command = "c", .date = "d", .reason = "first", .outcomes = {with(2e-4)}, .failing = {"a"}});
  const auto holds = [&](double uncertainty) {
    return compare(baseline, {.command = "c", .outcomes = {with(uncertainty)}}).holds();
  };
  CHECK(holds(2e-4));
  CHECK(holds(1.5e-4));
  CHECK(!holds(0.0));
}

TEST("a case without data may be judged later but not the reverse; wall clocks are not compared") {
  Outcome skipped = sample("a", 1e-5);
  skipped.skip("no data");
  skipped.quantities.clear();
  CHECK(compared({skipped}, {sample("a", 1e-5)}).holds());
  CHECK(!compared({skipped}, {sample("a", 1e-2)}).holds());  // judged for the first time, and fails
  CHECK(!compared({sample("a", 1e-5)}, {skipped}).holds());
  Outcome timed = sample("bench", 1e-5);
  timed.suite = "timing";
  timed.quantities = {{.name = "tick", .value = 1000.0, .unit = "instructions"},
                      {.name = "wall", .value = 5.0, .unit = "us"}};
  Outcome later = timed;
  later.quantities[1].value = 50.0;
  CHECK(compared({timed}, {later}).counts().identical == 1);
  later.quantities[0].value = 1020.0;
  CHECK(!compared({timed}, {later}).holds());
}

TEST("a partial approval moves one case, a whole one drops absent cases, and both are recorded") {
  const Baseline first = accepted(pair);
  const Baseline second = accept(first, {.command = "c",
                                         .date = "e",
                                         .reason = "a is another scheme now",
                                         .outcomes = {sample("a", 2e-5), sample("b", 3e-5)},
                                         .only = {"a"}});
  CHECK(second.find("a")->outcome.quantities[0].value == 2e-5);
  CHECK(second.find("b")->outcome.quantities[0].value == 1e-5);
  CHECK(second.command == "c");
  REQUIRE(second.ledger.size() == 2);
  CHECK(second.ledger[1].cases == std::vector<std::string>{"a"});
  const Baseline whole =
      accept(first, {.reason = "b is merged into a", .outcomes = {sample("a", 2e-5)}});
  CHECK(whole.find("b") == nullptr);
  const std::vector<std::string> lines = described_changes(first, whole);
  REQUIRE(lines.size() == 2);
  CHECK_CONTAINS(lines[0], "1e-05 -> 2e-05", "bound -inf to 0.001");
  CHECK(lines[1] == "b: dropped");
}

TEST("errors and NaN are not approved, and the spread is that of other builds") {
  Outcome broken = sample("a", 1e-5);
  broken.status = Status::error;
  CHECK_THROWS(accepted({broken}), "ran to its end");
  CHECK_THROWS(accepted({sample("a", std::nan(""))}), "error is nan");
  CHECK_THROWS(accepted({}), "nothing to approve");
  Acceptance acceptance{.reason = "r",
                        .outcomes = {sample("a", 1e-5)},
                        .variants = {{sample("a", 1.25e-5)}, {sample("a", 0.5e-5)}}};
  const Baseline baseline = accept({}, acceptance);
  CHECK_NEAR(baseline.cases[0].spread.quantities.at("error"), 0.5e-5, 1e-18);
  CHECK(baseline.cases[0].spread.runs == 2);
  acceptance.variants = {{sample("a", 1e-5)}};
  acceptance.variants[0][0].report("event: contact", 1.0, "s");
  CHECK_THROWS(accept({}, acceptance), "event: contact is in a variant only");
  acceptance.variants = {{sample("b", 1e-5)}};
  CHECK_THROWS(accept({}, acceptance), "is not in a variant");
}

TEST("a failing case is accepted only by name, and the approval says so") {
  Outcome failing = sample("a", 2e-3);
  CHECK(failing.status == Status::fail);
  CHECK_THROWS(accepted({failing}), "a: is fail; a case that passes, or --accept-failing a");
  const Baseline baseline =
      accept({}, {.reason = "known", .outcomes = {failing}, .failing = {"a"}});
  CHECK(described_changes({}, baseline).back() == "a: accepted although it is fail");
  CHECK(accept(baseline, {.reason = "b", .outcomes = {failing, pair[1]}, .only = {"b"}})
            .cases.size() == 2);
}

/// Outcome of a run with two events and one text.
Outcome run_with(double first, double second, const std::string& kernel) {
  Outcome outcome{.name = "run", .suite = "run", .claim = "scene"};
  const auto event = [&](const char* name, double at) {
    outcome.judge({.name = name, .value = at, .unit = "s", .uncertainty = 2e-3});
  };
  event("event: contact", first);
  event("event: puncture", second);
  outcome.tables.push_back(
      make_table(std::string(text_table), "", "", {"name", "text"}, {{"kernel", kernel}}));
  return outcome;
}

TEST("events may be exchanged by rounding only, and a changed text is named with both") {
  const auto verdict = [](Outcome before, Outcome now, bool exchanged) {
    if (exchanged) { std::swap(now.quantities[0], now.quantities[1]); }
    return compared({std::move(before)}, {std::move(now)});
  };
  CHECK(verdict(run_with(1.0, 1.001, "a"), run_with(1.001, 1.0, "a"), true).holds());
  CHECK(verdict(run_with(1.0, 1.001, "a"), run_with(1.0, 1.002, "a"), false).holds());
  const GateResult same_tick = verdict(run_with(1.0, 1.0, "a"), run_with(1.0, 1.0, "a"), true);
  CHECK_CONTAINS(same_tick.cases[0].outcome.reason(), "event: contact is listed after");
  CHECK(!verdict(run_with(1.0, 1.01, "a"), run_with(1.0, 1.01, "a"), true).holds());
  const GateResult other = verdict(run_with(1.0, 2.0, "a"), run_with(1.0, 2.0, "b"), false);
  CHECK_CONTAINS(other.cases[0].outcome.reason(), "kernel is b, was a");
  Outcome without = run_with(1.0, 2.0, "a");
  without.tables.clear();
  CHECK_CONTAINS(verdict(run_with(1.0, 2.0, "a"), without, false).cases[0].outcome.reason(),
                 "kernel is gone, was a");
  CHECK_CONTAINS(verdict(without, run_with(1.0, 2.0, "a"), false).cases[0].outcome.reason(),
                 "kernel is new: a");
}

TEST("a warning of some variants is not compared, and a moved event widens no curve") {
  Outcome first = run_with(1.0, 2.0, "a");
  first.tables[0].rows.push_back({"warning: too coarse", ""});
  first.figures.push_back(rupture(0.5));
  Outcome variant = run_with(1.0, 2.001, "a");
  variant.tables[0].rows.push_back({"warning: too fast", ""});
  variant.figures.push_back(rupture(0.499));
  const Baseline baseline =
      accept({}, {.reason = "r", .outcomes = {first}, .variants = {{variant}}});
  CHECK(compare(baseline, {.outcomes = {first}}).holds());
  CHECK(compare(baseline, {.outcomes = {variant}}).holds());
  variant.tables[0].rows.push_back({"warning: too slow", ""});
  CHECK(!compare(baseline, {.outcomes = {variant}}).holds());
  // The force falls by 2 N within a tick; along the curve it grows by 1e-3 N a tick.
  CHECK(baseline.cases[0].spread.curves.at("f: curve") < 1.1e-3);
  CHECK_NEAR(baseline.cases[0].spread.quantities.at("event: puncture"), 1e-3, 1e-15);
  CHECK_THROWS(accept({}, {.reason = "r",
                           .outcomes = {run_with(1.0, 2.0, "a")},
                           .variants = {{run_with(1.0, 2.0, "b")}}}),
               "kernel differs in a variant");
}

TEST(
    "a spread that is no rounding is printed, and the warning of a reduced model is not compared") {
  const Baseline wide = accept(
      {}, {.reason = "r", .outcomes = {sample("a", 1e-5)}, .variants = {{sample("a", 3e-5)}}});
  const std::vector<std::string> lines = described_changes({}, wide);
  REQUIRE(lines.size() == 2);
  CHECK_CONTAINS(lines[1], "rounding moves it by 2e-05, so the gate allows 0.0002");
  Outcome reduced = run_with(1.0, 2.0, "a");
  reduced.tables[0].rows.push_back({std::string(reduction_warning) + " the force", ""});
  CHECK(compared({reduced}, {run_with(1.0, 2.0, "a")}).holds());
  CHECK(compared({run_with(1.0, 2.0, "a")}, {reduced}).holds());
}

TEST("every damage to a result fails the gate") {
  check_status("gate/faults", nullptr, Status::pass);
}

#ifndef PALPATE_SANITIZED  // two hundred runs of code that the damage tests also execute
TEST("equal code never fails the gate") { check_status("gate/self", nullptr, Status::pass); }
#endif

}  // namespace PALPATE_FILE
