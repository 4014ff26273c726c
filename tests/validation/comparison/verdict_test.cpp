// SPDX-License-Identifier: MIT

#include <regex>

#include "model/problem/recording.hpp"
#include "tests/check.hpp"
#include "validation/claims/clinical_fixture.hpp"
#include "validation/comparison/comparison.hpp"

namespace {

using namespace palpate::comparison;
using namespace palpate;

TEST("every feature has one tolerance, in order, with its origin and limits that follow from it") {
  for (const QuantityKind kind : {QuantityKind::pressure, QuantityKind::force}) {
    const std::vector<Tolerance> all = default_tolerances(kind);
    REQUIRE(all.size() == feature_count);
    for (std::size_t n = 0; n < all.size(); ++n) {
      CHECK(all[n].feature == static_cast<Feature>(n));
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

}  // namespace
