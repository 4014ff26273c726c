// SPDX-License-Identifier: MIT

#include "validation/comparison/comparison.hpp"

#include <regex>

#include "tests/check.hpp"
#include "tests/validation/comparison/insertion_law.hpp"
#include "validation/claims/clinical_fixture.hpp"

namespace PALPATE_FILE {

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

TEST("an insertion is aligned by its contact and agrees with itself at another rate") {
  const Recording recording = recording_of(InsertionLaw{}, "a law");
  const Trace trace = trace_of(InsertionLaw{.rate = 500.0, .start = 1e-3});
  const Comparison found = compare(recording, trace, {.quantity = QuantityKind::insertion});
  CHECK(found.outcome.status == Status::pass);
  CHECK(found.alignment.used == AlignmentRule::contact);
  CHECK_NEAR(found.alignment.lag, 2.0, 0.012 + 1e-9);  // 4 mm at 2 mm/s; one sample of each
  CHECK(found.features.size() == features_of(QuantityKind::insertion).size());
  CHECK(found.of(Feature::puncture).status == Status::pass);
  CHECK(found.recorded.start >= 0.5 - 0.012);             // not from before the contact
  CHECK_NEAR(found.recorded_advance.end(), 20e-3, 2e-4);  // two steps of its grid
  const Comparison fast = compare(recording, trace_of(InsertionLaw{.speed = 4e-3}),
                                  {.quantity = QuantityKind::insertion});
  CHECK(fast.alignment.how ==
        "by the contact, at different speeds (2 mm/s recorded, 4 mm/s simulated)");
}

TEST("a puncture in one trace alone differs") {
  const Recording recording = recording_of(InsertionLaw{}, "a law");
  const Comparison found = compare(recording, trace_of(InsertionLaw{.left = 4.8, .rise = 20.0}),
                                   {.quantity = QuantityKind::insertion});
  CHECK(found.outcome.status == Status::fail);
  CHECK(found.of(Feature::puncture).status == Status::fail);
  CHECK(found.of(Feature::puncture_force).status == Status::skip);
  CHECK(sentence_of(found.of(Feature::puncture)) ==
        "puncture: not found in the simulated trace, found in the recorded one: differs");
}

TEST("a recording without the compared signal is refused") {
  const Recording recording = recording_of(InsertionLaw{}, "a law");
  const Comparison found = compare(recording, clinical::trace_of(ticks, pressures({}, ticks)));
  CHECK(found.outcome.status == Status::error);
  CHECK(found.outcome.reasons.front() == "pressure was not recorded");
  Recording without_depth = recording;
  without_depth.depth.clear();
  const Comparison blind =
      compare(without_depth, trace_of(InsertionLaw{}), {.quantity = QuantityKind::insertion});
  CHECK(blind.outcome.reasons.front() ==
        "no contact in the recording, which needs a depth and a force");
}

TEST("clocks that coincide are not shifted, and then times are judged") {
  const Recording recording = clinical::recording_of(ticks, pressures({}, ticks));
  const Trace late = clinical::trace_of(ticks, pressures({.delay = 0.7}, ticks));
  const Comparison found = compare(recording, late, {.alignment = AlignmentRule::clock});
  CHECK(found.alignment.lag == 0.0);
  CHECK(found.alignment.judges_times());
  CHECK(found.of(Feature::time_of_loss).status == Status::fail);
  CHECK_NEAR(found.of(Feature::time_of_loss).error, 0.7, 0.01);  // a sample
}

TEST("features that agree do not hide a curve that is rated poor") {
  const Recording recording = clinical::recording_of(ticks, pressures({}, ticks));
  std::vector<double> other = pressures({}, ticks);
  // Before the slope and after the plateau, where no feature is measured.
  for (std::size_t n = 0; n < other.size(); ++n) {
    if (ticks[n] < 3.0 || ticks[n] > 11.5) { other[n] = 58.0 * pascals_per_mmhg; }
  }
  const Comparison found = compare(recording, clinical::trace_of(ticks, other));
  for (const FeatureComparison& one : found.features) {
    CHECK((one.status == Status::pass || one.status == Status::skip));
  }
  REQUIRE(found.rating.has_value());
  CHECK(grade_of(found.rating->overall) == "poor");
  CHECK(found.only_curve_differs);
  CHECK(found.outcome.status == Status::fail);
  REQUIRE(!found.outcome.reasons.empty());
  CHECK(found.outcome.reasons.front().starts_with("features agree, curve does not: rated 0."));
}

TEST("every feature has one tolerance, in order, with its origin and limits that follow from it") {
  for (const QuantityKind kind :
       {QuantityKind::pressure, QuantityKind::force, QuantityKind::insertion}) {
    const std::vector<Tolerance> all = default_tolerances(kind);
    REQUIRE(all.size() == features_of(kind).size());
    for (std::size_t n = 0; n < all.size(); ++n) {
      CHECK(all[n].feature == features_of(kind)[n]);
      CHECK(!all[n].origin.empty());
    }
  }
  const Tolerance peak =
      default_tolerances(QuantityKind::pressure)[static_cast<std::size_t>(Feature::peak)];
  // From the midpoint of 376 and 461 mmHg, the group means of the trial, the tolerance includes
  // exactly both values.
  CHECK_NEAR(peak.lower(418.5), 376.0, 1e-9);
  CHECK_NEAR(peak.upper(418.5), 461.0, 1e-9);
  const Tolerance factor{.feature = Feature::drop_time, .factor = 2.0};
  CHECK_NEAR(factor.lower(0.1), 0.05, 1e-15);
  CHECK_NEAR(factor.upper(0.1), 0.2, 1e-15);
  const Tolerance both{.absolute = 1.0, .relative = 0.1};  // relative to the size
  CHECK_NEAR(both.lower(-10.0), -12.0, 1e-15);
  CHECK_NEAR(both.upper(-10.0), -8.0, 1e-15);
}

/// Status of a simulated value compared with a recorded value of 10.
Status status_of(double simulated, double tolerance, double uncertainty) {
  FeatureComparison one{.tolerance = {.absolute = tolerance}, .uncertainty = {.data = uncertainty}};
  judge_difference(one, 10.0, simulated, 1.0);
  return one.status;
}

TEST("a difference agrees within its tolerance, differs beyond it, and is open between") {
  CHECK_NEAR((ValidationUncertainty{.numerical = 2.0, .input = 3.0, .data = 6.0}.total()), 7.0,
             1e-15);  // uncertainties add in squares
  CHECK(std::isnan(ValidationUncertainty{.data = std::nan("")}.total()));
  CHECK(std::isnan(ValidationUncertainty{.numerical = std::nan("")}.total()));
  CHECK(status_of(10.0, 1.0, 0.5) == Status::pass);
  CHECK(status_of(10.8, 1.0, 0.5) == Status::inconclusive);
  CHECK(status_of(11.2, 1.0, 0.5) == Status::inconclusive);
  CHECK(status_of(11.6, 1.0, 0.5) == Status::fail);
  CHECK(status_of(8.4, 1.0, 0.5) == Status::fail);
  CHECK(status_of(10.0, 1.0, 5.0) == Status::inconclusive);  // larger than the tolerance
  CHECK(status_of(not_measured, 1.0, 0.1) == Status::error);
  CHECK(status_of(10.0, not_measured, 0.1) == Status::error);
  CHECK(status_of(10.0, 1.0, unbounded) == Status::error);
}

TEST("the worst verdict is that of the whole, its reasons are first, and words are contracted") {
  CHECK(worse(Status::pass, Status::fail) == Status::fail);
  CHECK(worse(Status::inconclusive, Status::pass) == Status::inconclusive);
  CHECK(worse(Status::skip, Status::pass) == Status::pass);
  CHECK(worse(Status::inconclusive, Status::fail) == Status::fail);
  CHECK(verdict_word(Status::pass) == "agrees");
  CHECK(verdict_word(Status::fail) == "differs");
  CHECK(verdict_word(Status::inconclusive) == "not distinguishable");
  CHECK(verdict_word(Status::error) == "not comparable");
  CHECK(verdict_word(Status::skip) == "not judged");
  Outcome outcome;  // equal reasons keep their order
  conclude(outcome, {{Status::inconclusive, "a"},
                     {Status::fail, "b"},
                     {Status::skip, "c"},
                     {Status::fail, "d"},
                     {Status::inconclusive, "e"}});
  CHECK(outcome.status == Status::fail);
  CHECK(outcome.reasons == std::vector<std::string>({"b", "d", "a", "e", "c"}));
}

/// Both sides with all features at 100, except the peak.
Comparison given(double recorded_peak, double simulated_peak) {
  Comparison comparison{.unit = "Pa"};
  for (Measured& m : comparison.recorded_features.all) { m.value = 100.0; }
  comparison.simulated_features = comparison.recorded_features;
  comparison.recorded_features.loss.peak = 100.0;
  comparison.recorded_features.loss.relative_drop = 0.5;
  comparison.recorded_features[Feature::peak].value = recorded_peak;
  comparison.simulated_features[Feature::peak].value = simulated_peak;
  return comparison;
}

FeatureComparison compared(Feature feature, const Comparison& comparison,
                           const ComparisonOptions& options = {}) {
  return compare_features(comparison, options)[static_cast<std::size_t>(feature)];
}

TEST("the error, interval and uncertainty of a feature are those by hand") {
  ComparisonOptions options;
  options.uncertainties = {.transducer = {.zero = 30.0, .gain = 0.01},
                           .numerical = 0.02,
                           .input = 0.03,
                           .coverage_factor = 2.0};
  Comparison comparison = given(10000.0, 10500.0);
  comparison.recorded_features[Feature::peak].uncertainty = 40.0;
  const FeatureComparison peak = compared(Feature::peak, comparison, options);
  CHECK_NEAR(peak.error, 500.0, 1e-9);
  CHECK_NEAR(peak.uncertainty.data, std::sqrt(40.0 * 40.0 + 30.0 * 30.0 + 100.0 * 100.0), 1e-9);
  CHECK_NEAR(peak.uncertainty.numerical, 210.0, 1e-9);
  CHECK_NEAR(peak.uncertainty.input, 315.0, 1e-9);
  CHECK_NEAR(peak.quantity.uncertainty, 2.0 * std::sqrt(12500.0 + 210.0 * 210.0 + 315.0 * 315.0),
             1e-9);
  CHECK(peak.status == Status::inconclusive);  // 500 + 790 > 1015
}

TEST("an offset of the transducer moves peak and plateau, and cancels in a height and in times") {
  ComparisonOptions options;
  options.uncertainties = {.transducer = {.zero = 50.0, .gain = 0.0}};
  const Comparison comparison = given(100.0, 100.0);
  for (const auto& [feature, expected] :
       {std::pair{Feature::peak, 50.0},
        {Feature::plateau, 50.0},
        {Feature::drop_height, 0.0},
        {Feature::drop_time, 0.0},
        // d (1 - plateau / peak) / d offset = relative_drop / peak, in size
        {Feature::relative_drop, 50.0 * 0.5 / 100.0}}) {
    CHECK_NEAR(data_uncertainty(feature, comparison.recorded_features, options), expected, 1e-12);
  }
}

TEST("times are given on the simulation's clock, and judged only if the start aligned the clocks") {
  Comparison comparison = given(100.0, 100.0);
  comparison.alignment = {.used = AlignmentRule::start, .lag = 30.0, .uncertainty = 0.1};
  const FeatureComparison time = compared(Feature::time_of_loss, comparison);
  CHECK_NEAR(*time.recorded.value, 70.0, 1e-12);
  CHECK_NEAR(time.error, 30.0, 1e-12);
  CHECK_NEAR(time.uncertainty.data, 0.1, 1e-12);
  CHECK(time.status == Status::fail);
  for (const auto& [rule, reason] :
       {std::pair{AlignmentRule::depth, "the clocks were aligned by the depth"},
        std::pair{AlignmentRule::event, "the clocks were aligned by the event"}}) {
    comparison.alignment = {.used = rule, .how = "by something", .lag = 30.0};
    const FeatureComparison unjudged = compared(Feature::time_of_loss, comparison);
    CHECK(unjudged.status == Status::skip);
    CHECK(unjudged.reason == reason);
    CHECK_NEAR(unjudged.error, 30.0, 1e-12);  // reported, though not judged
  }
  CHECK(compared(Feature::depth_of_loss, comparison).status == Status::pass);
}

TEST("an event in one trace alone differs, an undecided one is open, other gaps are not judged") {
  const Measured found{.value = 1.0}, absent{.value = 0.0};
  const Measured ends{.reason = "the trace ends"}, gap{.reason = "a gap"};
  const Feature event = Feature::loss_of_resistance;
  struct {
    Feature feature;
    Measured recorded, simulated;
    Status status;
    const char* reason;
  } const rows[] = {
      {event, found, absent, Status::fail, ""},
      {event, found, ends, Status::inconclusive, "simulated: the trace ends"},
      {event, ends, ends, Status::inconclusive, "in neither: the trace ends"},
      {event, ends, gap, Status::inconclusive, "recorded: the trace ends; simulated: a gap"},
      {Feature::depth_of_peak, ends, gap, Status::skip,
       "recorded: the trace ends; simulated: a gap"},
  };
  for (const auto& row : rows) {
    Comparison comparison = given(100.0, 100.0);
    comparison.recorded_features[row.feature] = row.recorded;
    comparison.simulated_features[row.feature] = row.simulated;
    const FeatureComparison one = compared(row.feature, comparison);
    CHECK(one.status == row.status);
    CHECK(one.reason == row.reason);
  }
}

/// Text with spaces instead of non-breaking spaces.
std::string plain(const std::string& text) {
  return std::regex_replace(text, std::regex("\u00a0|\u202f"), " ");
}

TEST("values and tolerances are shown in the units of clinicians") {
  const auto text = [](Feature feature, double value, const char* unit) {
    return plain(shown(feature, value, unit));
  };
  CHECK(text(Feature::peak, 461.0 * pascals_per_mmhg, "Pa") == "461 mmHg");
  CHECK(text(Feature::depth_of_loss, 0.0393, "m") == "39.3 mm");
  CHECK(text(Feature::relative_drop, 0.87, "1") == "87 %");
  CHECK(text(Feature::slope_before, -2.5 * pascals_per_mmhg, "Pa/s") == "−2.5 mmHg/s");
  CHECK(text(Feature::loss_of_resistance, 0.0, "1") == "not found");
  CHECK(text(Feature::peak, not_measured, "Pa") == "-");
  // A value that rounds to zero is shown without a sign.
  CHECK(text(Feature::slope_before, -1.058e-5 * pascals_per_mmhg, "Pa/s") == "0 mmHg/s");
  CHECK(text(Feature::drop_time, -1e-9, "s") == "0 s");
  const Tolerance plateau{.feature = Feature::plateau, .absolute = 7.0 * pascals_per_mmhg};
  CHECK(plain(shown(plateau, "Pa")) == "7 mmHg");
  CHECK(shown(Tolerance{.feature = Feature::drop_time, .factor = 2.0}, "s") == "a factor of 2");
  CHECK(shown(Tolerance{.feature = Feature::loss_of_resistance}, "1") == "the same");
}

TEST("a sentence has both values, the tolerance, the uncertainty and the verdict, or the reason") {
  FeatureComparison event{.feature = Feature::loss_of_resistance, .status = Status::fail};
  event.recorded.value = 1.0;
  event.simulated.value = 0.0;
  CHECK(sentence_of(event) ==
        "loss of resistance: not found in the simulated trace, found in the recorded one: differs");
  FeatureComparison drop{
      .feature = Feature::relative_drop,
      .quantity = {.unit = "1", .lower = 0.67, .upper = 1.07, .uncertainty = 0.012},
      .status = Status::fail};
  drop.recorded.value = 0.87;
  drop.simulated.value = 0.5;
  CHECK(plain(sentence_of(drop)) ==
        "relative drop: 50 % simulated, 87 % recorded; 67 to 107 % allowed, known to ±1.2 %: "
        "differs");
  const FeatureComparison depth{.feature = Feature::depth_of_peak,
                                .status = Status::skip,
                                .reason = "in neither: depth was not recorded"};
  CHECK(sentence_of(depth) == "depth of peak: in neither: depth was not recorded: not judged");
}

}  // namespace PALPATE_FILE
