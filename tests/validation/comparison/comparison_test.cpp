// SPDX-License-Identifier: MIT

#include "validation/comparison/comparison.hpp"

#include "tests/check.hpp"
#include "validation/claims/clinical_fixture.hpp"

namespace {

using namespace palpate::comparison;
using namespace palpate;
using clinical::instants;
using clinical::PressureLaw;
using clinical::pressures;
using clinical::recording_of;
using clinical::trace_of;

/// Analytic signal with a clock offset `clock` [s], and a needle that has moved at `speed` since
/// the rise.
PreparedTrace prepared(const PressureLaw& law, double clock, double speed = 0.0) {
  std::vector<double> time = instants(16.0, 200.0);
  const std::vector<double> value = pressures(law, time);
  std::vector<double> depth;
  for (double& t : time) {
    if (speed > 0.0) { depth.push_back(0.02 + speed * (t - law.delay)); }
    t += clock;
  }
  return prepare({time, value, depth}, 20.0, {});
}

TEST("clocks are aligned by depth, else by event or start, and the lag is that of the law") {
  using enum AlignmentRule;
  struct {
    PreparedTrace recorded, simulated;
    AlignmentRule rule, used;
    double lag;
  } const rows[] = {
      {prepared({}, 100.0), prepared({.delay = 1.0}, 0.0), automatic, event, 99.0},
      // Both needles are at the same depth.
      {prepared({}, 50.0, 0.005), prepared({.delay = 2.0}, 0.0, 0.005), automatic, depth, 48.0},
      // The loss is one second later: over depth no lag can hide it.
      {prepared({.loss = 6.0}, 0.0, 0.005), prepared({.loss = 7.0}, 0.0, 0.005), depth, depth, 0.0},
      {prepared({}, 30.0), prepared({.delay = 1.0}, 10.0), start, start, 20.0},
  };
  for (const auto& row : rows) {
    const Alignment found = align(row.recorded, row.simulated, row.rule);
    CHECK(found.used == row.used);
    CHECK(found.judges_times() == (row.used == start));
    CHECK(found.not_by_depth.empty());
    CHECK_NEAR(found.lag, row.lag, row.used == start ? 1e-9 : 1e-6);  // rounding; interpolation
    if (row.used == event) { CHECK(found.how == "by the loss of resistance"); }
  }
  // Without a loss in both the peak is taken.
  const Alignment by_peak =
      align(prepared({}, 0.0), prepared({.plateau = PressureLaw{}.peak}, 5.0), event);
  CHECK(by_peak.refusal.empty());
  CHECK_CONTAINS(by_peak.how, "peak");
}

TEST("depth that is missing or does not overlap is refused when required, not replaced") {
  const PreparedTrace with_depth = prepared({}, 0.0, 0.005);
  const auto refusal = [](const PreparedTrace& recorded, const PreparedTrace& simulated) {
    return align(recorded, simulated, AlignmentRule::depth).refusal;
  };
  CHECK(refusal(prepared({}, 0.0), with_depth) == "the recording has no depth");
  CHECK(refusal(with_depth, prepared({}, 0.0)) == "the simulated trace has no depth");
  PreparedTrace deep = with_depth;
  for (double& d : deep.input.depth.value) { d += 1.0; }
  CHECK_CONTAINS(refusal(deep, with_depth), "do not meet");
  PreparedTrace late = with_depth;
  late.input.depth.value[0] = 0.2;  // drawn back at once, as it seems
  CHECK(!refusal(late, with_depth).empty());
}

TEST("with a gap over the depth of the event the event aligns the clocks, for a given reason") {
  PreparedTrace gap = prepared({}, 50.0, 0.005);
  // The event is at 6.1 s, so depth is missing within 0.5 s on either side of it.
  for (std::size_t n = 0; n < gap.input.depth.size(); ++n) {
    if (std::abs(gap.input.depth.time(n) - 56.1) < 0.5) { gap.input.depth.value[n] = not_measured; }
  }
  const PreparedTrace whole = prepared({.delay = 2.0}, 0.0, 0.005);
  const double depth = 1e3 * *whole.features[Feature::depth_of_loss].value;
  char expected[80];
  std::snprintf(expected, sizeof expected, "a gap hides when the simulated tip reached %.1f mm",
                depth);
  CHECK(align(whole, gap, AlignmentRule::depth).refusal == expected);
  const Alignment found = align(whole, gap, AlignmentRule::automatic);
  CHECK(found.used == AlignmentRule::event);
  CHECK(found.not_by_depth == expected);
  CHECK(found.how == "by the loss of resistance, not by depth: " + std::string(expected));
  CHECK_NEAR(found.lag, 2.0 - 50.0, 1e-6);
}

const std::vector<double> time_of_link = instants(14.0, 120.0);
const std::vector<double> ticks = instants(14.0, 1000.0);

Recording recorded() { return recording_of(time_of_link, pressures({}, time_of_link)); }
Trace simulated() { return trace_of(ticks, pressures({}, ticks)); }

void check_refused(const Recording& recording, const Trace& trace, const std::string& reason,
                   const ComparisonOptions& options = {}) {
  const Comparison found = compare(recording, trace, options);
  CHECK(found.outcome.status == Status::error);
  REQUIRE(found.outcome.reasons.size() == 1);
  CHECK(found.outcome.reasons.front() == reason);
}

TEST("one law at two rates agrees") {
  const Comparison found = compare(recorded(), simulated());
  CHECK(found.outcome.status == Status::pass);
  CHECK(found.outcome.reasons.empty());
  // Filters of two rates differ by less than half a sample.
  CHECK_NEAR(found.alignment.lag, 0.0, 0.5 / 120.0);
  CHECK(found.rating);
  CHECK(found.rating->overall > 0.98);
  CHECK(found.kind == Recording::Kind::reconstructed);
  const Comparison coarse = compare(recorded(), simulated(), {.most_samples = 500});
  CHECK(coarse.recorded.size() <= 501);  // the largest grid that its ratings allow
  CHECK(coarse.outcome.status == Status::pass);
  CHECK_NEAR(found.cutoff, 20.0, 0.0);
}

TEST("a recording that cannot be compared has a reason") {
  const auto changed = [](auto change) {
    Recording recording = recorded();
    change(recording);
    return recording;
  };
  const auto filled = [&](double value) {
    return changed([value](Recording& r) { std::ranges::fill(r.pressure, value); });
  };
  check_refused({}, simulated(), "the recording is empty");
  check_refused(recorded(), Trace{}, "the simulated trace has no column syringe.pressure_pa");
  check_refused(filled(3.0), simulated(), "the recording is constant");
  check_refused(filled(not_measured), simulated(), "the recording holds no number");
  check_refused(changed([](Recording& r) { r.time = r.pressure = {1.0}; }), simulated(),
                "the recording has one sample");
  check_refused(changed([](Recording& r) { r.regime = Recording::Regime::pump; }), simulated(),
                "wrong regime: recorded with a pump on the plunger, simulated with a thumb");
  check_refused(recorded(), simulated(), "force along the needle was not recorded",
                {.quantity = QuantityKind::force, .column = "syringe.pressure_pa"});
}

TEST("traces without a common time do not overlap") {
  Recording recording = recorded();
  for (double& t : recording.time) { t += 10.0; }
  const ComparisonOptions options{.alignment = AlignmentRule::start};
  // Starts coincide, wherever they are.
  CHECK(compare(recording, simulated(), options).outcome.status == Status::pass);
  const std::vector<double> early = instants(0.5, 1000.0);
  // 0 to 0.5 s at 120 Hz: 61 samples, each for 1/120 s.
  check_refused(recording, trace_of(early, early),
                "no overlap in time but for 0.5083 s in 61 samples; 1 s in 20 are needed", options);
}

TEST("the time of an event that aligned the clocks is not judged") {
  const Trace later = trace_of(ticks, pressures({.delay = 1.0}, ticks));
  const Comparison found = compare(recorded(), later);
  const FeatureComparison& loss = found.features[static_cast<std::size_t>(Feature::time_of_loss)];
  CHECK(loss.status == Status::skip);
  CHECK(!loss.reason.empty());
  CHECK_NEAR(found.alignment.lag, -1.0, 0.01);
  CHECK(compare(recorded(), later, {.alignment = AlignmentRule::start}).outcome.status ==
        Status::fail);
}

TEST("gaps in the recording are not compared") {
  Recording gappy = recorded();
  for (std::size_t n = 240; n < 300; ++n) { gappy.pressure[n] = not_measured; }
  const Comparison found = compare(gappy, simulated());
  CHECK(found.outcome.status == Status::pass);
  CHECK(found.errors.samples <= found.recorded.size() - 60);
  CHECK(found.rated < 1.0);
  CHECK(found.rated > 0.7);
  for (std::size_t n = 242; n < 298; ++n) { CHECK(std::isnan(found.recorded.value[n])); }
}

TEST("a given tolerance replaces the default; one below the uncertainty leaves the verdict open") {
  const ComparisonOptions strict{
      .tolerances = {{.feature = Feature::peak, .relative = 0.03, .origin = "stricter"}}};
  const Trace louder = trace_of(ticks, pressures({.peak = 64.0 * pascals_per_mmhg}, ticks));
  CHECK(compare(recorded(), louder).outcome.status != Status::fail);
  CHECK(compare(recorded(), louder, strict).outcome.status == Status::fail);
  const ComparisonOptions vague{.uncertainties = {.input = 0.3}};
  const PressureLaw loud{.peak = 66.0 * pascals_per_mmhg, .plateau = 8.8 * pascals_per_mmhg};
  const Comparison found = compare(recorded(), trace_of(ticks, pressures(loud, ticks)), vague);
  CHECK(found.outcome.status == Status::inconclusive);
  CHECK(found.features[static_cast<std::size_t>(Feature::peak)].below_uncertainty);
}

TEST("a force along the needle is compared with its own column") {
  Recording recording = recorded();
  recording.force = recording.pressure;
  for (double& f : recording.force) { f *= 1.767e-4; }
  Trace trace = simulated();
  trace.columns.front().name = "tool.force_n";
  for (double& f : trace.columns.front().values) { f *= 1.767e-4; }
  const Comparison found = compare(recording, trace, {.quantity = QuantityKind::force});
  CHECK(found.outcome.status == Status::pass);
  CHECK(found.unit == "N");
}

}  // namespace
