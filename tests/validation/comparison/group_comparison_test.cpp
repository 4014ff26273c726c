// SPDX-License-Identifier: MIT

#include "validation/comparison/group_comparison.hpp"

#include "tests/check.hpp"
#include "tests/validation/comparison/insertion_law.hpp"
#include "validation/claims/clinical_fixture.hpp"

namespace PALPATE_FILE {

using namespace palpate::comparison;
using namespace palpate;
using clinical::PressureLaw;
using Shown = CredibilityFactor::Shown;

const std::vector<double> time_of_link = clinical::instants(14.0, 120.0);
const std::vector<double> ticks = clinical::instants(14.0, 1000.0);

/// Subject whose pressures are all scaled by a factor.
Recording subject(double factor, const std::string& group = "lean") {
  std::vector<double> pressure = clinical::pressures({}, time_of_link);
  for (double& p : pressure) { p *= factor; }
  Recording recording = clinical::recording_of(time_of_link, pressure);
  recording.name = "subject " + std::to_string(factor);
  recording.group = group;
  return recording;
}

Trace simulated(const PressureLaw& law = {}) {
  return clinical::trace_of(ticks, clinical::pressures(law, ticks));
}

std::vector<Recording> subjects() {
  return {subject(0.8), subject(0.9), subject(1.0), subject(1.1), subject(1.2)};
}

GroupComparison lean(const Trace& trace) { return compare_all(subjects(), trace); }

const FeatureSummary& summary(const GroupSummary& group, Feature feature) {
  return group.features[static_cast<std::size_t>(feature)];
}

/// Both end before the event can be detected.
Trace cut_trace() {
  const std::vector<double> until = clinical::instants(8.5, 1000.0);
  return clinical::trace_of(until, clinical::pressures({}, until));
}
Recording cut(Recording recording) {
  while (recording.time.back() > 8.5) {
    recording.time.pop_back();
    recording.pressure.pop_back();
  }
  return recording;
}

TEST("an insertion in the middle of its subjects agrees with the group, not with each") {
  const GroupComparison found = lean(simulated());
  REQUIRE(found.groups.size() == 1);
  const GroupSummary& group = found.groups.front();
  CHECK(group.corridor);
  CHECK(group.coverage.holds);
  CHECK(group.tally.failed > 0);
  CHECK(group.tally.passed > 0);
  CHECK(group.recordings == 5);
  CHECK(group.measured == 0);
  // 79 % of the peak tolerance remains after the spread of a mean of five: never different.
  CHECK(group.outcome.status != Status::fail);
  CHECK(group.outcome.status != Status::error);
  const FeatureSummary& peak = summary(group, Feature::peak);
  const double middle = *found.recordings[2].recorded_features[Feature::peak].value;  // factor 1
  CHECK(peak.count == 5);
  CHECK_NEAR(peak.mean, middle, 1e-9 * middle);
  CHECK_NEAR(peak.deviation, middle * std::sqrt(0.1 / 4.0), 1e-9 * middle);
  REQUIRE(peak.interval.has_value());
  CHECK(peak.interval->holds(peak.mean));
}

TEST("the spread of a mean over subjects is part of its uncertainty") {
  std::vector<double> louder = clinical::pressures({}, ticks);
  for (double& p : louder) { p *= 1.15; }
  // Off by 15 % where 10.2 % are allowed, but the mean of five is known to 2 x 15.8 % / sqrt(5) =
  // 14 %.
  CHECK(lean(clinical::trace_of(ticks, louder)).outcome.status == Status::inconclusive);
}

TEST("a trace that leaves the corridor differs, also if its features agree") {
  std::vector<double> odd = clinical::pressures({}, ticks);
  // Long before the event.
  for (std::size_t n = 0; n < 2500; ++n) { odd[n] += 30.0 * pascals_per_mmhg; }
  const GroupComparison found = lean(clinical::trace_of(ticks, odd));
  CHECK(found.recordings[2].outcome.status == Status::pass);  // by features alone, factor 1
  CHECK(found.outcome.status == Status::fail);
  CHECK(found.groups.front().coverage.inside < 0.9);
  CHECK(found.groups.front().coverage.inside > 0.7);
  const GroupComparison no_event = lean(simulated({.plateau = PressureLaw{}.peak}));
  CHECK(no_event.outcome.status == Status::fail);
  CHECK(!no_event.groups.front().coverage.holds);
  CHECK_CONTAINS(no_event.outcome.reasons.front(), "in the corridor of 5 subjects");
}

/// Insertions with two needles whose forces and depths have a mean of 1 and a standard deviation of
/// 0.0316.
std::vector<Recording> repeats() {
  std::vector<Recording> all;
  for (const double factor : {0.96, 0.98, 1.0, 1.02, 1.04}) {
    all.push_back(recording_of(InsertionLaw{.exponent = 1.4 * factor,
                                            .dent = 12e-3 * factor,
                                            .relaxed = 0.4 * factor,
                                            .relaxation_time = 1.2 * factor,
                                            .pulled_at = 15e-3 * factor,
                                            .factor = factor},
                               std::to_string(factor)));
    all.back().group = "skin";
    all.back().subject = factor < 1.0 ? "needle 2" : "needle 3";
  }
  return all;
}
const GroupOptions of_insertion{.comparison = {.quantity = QuantityKind::insertion}};

TEST("of a phantom every recording counts, and two deviations over the repeats are the tolerance") {
  const GroupComparison found = compare_all(repeats(), trace_of(InsertionLaw{}), of_insertion);
  REQUIRE(found.groups.size() == 1);
  const GroupSummary& group = found.groups.front();
  CHECK(group.subjects == 5);
  CHECK(group.phantoms == 5);
  CHECK(group.measured == 0);
  REQUIRE(group.corridor.has_value());
  CHECK(group.corridor->subjects == 5);
  REQUIRE(group.advance_corridor.has_value());
  const FeatureComparison& force = found.recordings[0].of(Feature::puncture_force);
  const double deviation = std::sqrt(0.001);  // of 0.96 ... 1.04, (16 + 4 + 0 + 4 + 16) 1e-4 / 4
  const double puncture = *found.recordings[2].recorded_features[Feature::puncture_force].value;
  CHECK_NEAR(force.tolerance.absolute, 2.0 * deviation * puncture, 1e-3 * puncture);
  CHECK(force.tolerance.relative == 0.0);
  CHECK(force.tolerance.origin == "two standard deviations over 5 recordings of the group");
  CHECK(group.outcome.reason() == "");
  CHECK(group.outcome.status == Status::pass);
  CHECK(group.coverage.holds);
  const FeatureComparison& mean = group.means[1];
  CHECK(mean.feature == Feature::puncture_force);
  // u_D is the standard error of the mean; the recordings have no noise, and a gain of 1 %.
  CHECK_NEAR(mean.uncertainty.data, puncture * std::hypot(deviation / std::sqrt(5.0), 0.01),
             1e-3 * puncture);
}

TEST("an insertion beyond the spread of the repeats differs") {
  const GroupComparison found =
      compare_all(repeats(), trace_of(InsertionLaw{.factor = 1.2}), of_insertion);
  CHECK(found.outcome.status == Status::fail);
  CHECK(!found.groups.front().only_curve_differs);
  CHECK(found.groups.front().means[1].status == Status::fail);
}

TEST(
    "the uncertainty of the measurement is the least tolerance of repeats, and a given one stays") {
  std::vector<Recording> same(3, recording_of(InsertionLaw{}, "one"));
  device::Seeded seeded(3);
  clinical::add_noise(same.front().force, 0.02, seeded);
  for (Recording& one : same) { one.force = same.front().force; }
  const GroupComparison found = compare_all(same, trace_of(InsertionLaw{}), of_insertion);
  const FeatureComparison& force = found.recordings[0].of(Feature::puncture_force);
  CHECK_NEAR(force.tolerance.absolute, 4.0 * force.recorded.uncertainty, 1e-12);
  CHECK(force.tolerance.origin.starts_with("twice the expanded uncertainty of the measurement"));
  GroupOptions options = of_insertion;
  options.comparison.tolerances = {{.feature = Feature::puncture_force, .absolute = 0.7}};
  const GroupComparison given = compare_all(same, trace_of(InsertionLaw{}), options);
  CHECK(given.recordings[0].of(Feature::puncture_force).tolerance.absolute == 0.7);
  same.pop_back();
  const GroupComparison two = compare_all(same, trace_of(InsertionLaw{}), of_insertion);
  CHECK(two.recordings[0].of(Feature::puncture_force).tolerance.origin.starts_with("assumption"));
}

TEST("features that agree with the repeats do not hide a curve outside their corridor") {
  const InsertionLaw law;
  Trace trace = trace_of(law);
  for (std::size_t n = 0; n < trace.time.size(); ++n) {
    const double depth = law.depth_at(trace.time[n]);
    const bool withdrawn = trace.time[n] > law.advance_time() + law.hold;
    // Added to 6 of 25 s, in which no feature is measured.
    if (withdrawn && depth > 2e-3 && depth < 14e-3) {
      trace.columns[0].values[n] += 4.0 * std::pow(std::sin((depth - 2e-3) / 12e-3 * 3.1416), 2);
    }
  }
  const GroupComparison found = compare_all(repeats(), trace, of_insertion);
  CHECK(found.outcome.status == Status::fail);
  CHECK(found.groups.front().only_curve_differs);
  CHECK_CONTAINS(found.outcome.reasons.front(), "features agree, curve does not: ",
                 "of samples lie in the corridor of 5 recordings; 90 % needed");
  const GroupComparison strong =
      compare_all(repeats(), trace_of(InsertionLaw{.factor = 1.5}), of_insertion);
  CHECK(!strong.groups.front().coverage.holds);
  CHECK(!strong.groups.front().only_curve_differs);
}

TEST("a puncture is what most recordings of a group show") {
  std::vector<Recording> all = repeats();
  Recording none = recording_of(InsertionLaw{.left = 4.8, .rise = 20.0}, "none");
  none.group = "skin";
  all.push_back(none);
  const GroupComparison found = compare_all(all, trace_of(InsertionLaw{}), of_insertion);
  CHECK(found.groups.front().means[0].feature == Feature::puncture);
  CHECK(found.groups.front().means[0].status == Status::pass);
  CHECK(found.groups.front().features[1].count == 5);
}

TEST("recordings of a phantom are no evidence about subjects") {
  const GroupComparison found = compare_all(repeats(), trace_of(InsertionLaw{}), of_insertion);
  for (const CredibilityFactor& factor : credibility({}, &found)) {
    if (factor.activity != "validation") { continue; }
    CHECK(factor.shown == Shown::not_shown);
    if (factor.factor != "test samples") { continue; }
    CHECK(factor.evidence ==
          "not shown: no measured recording was compared; 5 of a measured phantom are no subjects");
  }
}

TEST("a simulation that ends before its event can be detected leaves the verdict open") {
  const GroupComparison one = lean(cut_trace());
  for (const Outcome& outcome : {one.outcome, one.recordings[2].outcome}) {
    CHECK(outcome.status == Status::inconclusive);
    CHECK_CONTAINS(outcome.reasons.front(), "the trace ends");
  }
  const std::vector<Recording> recordings{cut(subject(1.0))};
  const GroupComparison both = compare_all(recordings, cut_trace());
  CHECK(both.outcome.status == Status::inconclusive);
  CHECK_CONTAINS(both.outcome.reasons.front(), "loss of resistance: in neither: the trace ends");
}

TEST("a gap over the fall of the first recording does not affect the others") {
  std::vector<Recording> all = subjects();
  for (std::size_t n = 0; n < all[0].time.size(); ++n) {
    if (all[0].time[n] > 6.05 && all[0].time[n] < 6.25) { all[0].pressure[n] = not_measured; }
  }
  const GroupComparison found = compare_all(all, simulated({.fall_constant = 0.75}));
  CHECK(summary(found.groups.front(), Feature::drop_time).count == 4);
  CHECK(std::ranges::any_of(found.outcome.reasons, [](const std::string& reason) {
    return check::contains(reason, "drop time");
  }));
  CHECK(found.outcome.status == Status::fail);
}

TEST("two recordings have no corridor; they are judged one by one") {
  const std::vector<Recording> two{subject(1.0, "a"), subject(1.5, "a")};
  const GroupComparison found = compare_all(two, simulated());
  CHECK(!found.groups.front().corridor);
  CHECK(found.groups.front().corridor_refusal ==
        "a corridor needs at least 3 subjects; there are 2");
  CHECK(found.outcome.status == Status::fail);
  CHECK(!found.groups.front().features.front().interval);
}

TEST("each group has its own summary, in the order of the first recordings") {
  std::vector<Recording> all = subjects();
  all.insert(all.begin() + 1, subject(2.0, "heavy"));
  const GroupComparison found = compare_all(all, simulated());
  REQUIRE(found.groups.size() == 2);
  CHECK(found.groups[0].group == "lean");
  CHECK(found.groups[1].group == "heavy");
  CHECK(found.groups[0].recordings == 5);
  CHECK(found.groups[1].recordings == 1);
  CHECK(found.outcome.status == Status::fail);
}

TEST("recordings that cannot be compared are counted and left out") {
  std::vector<Recording> all = subjects();
  all[3].regime = Recording::Regime::pump;
  const GroupSummary group = compare_all(all, simulated()).groups.front();
  CHECK(group.tally.errors == 1);
  CHECK(group.corridor->recordings == 4);
  const std::vector<Recording> none{all[3]};
  CHECK(compare_all(none, simulated()).outcome.status == Status::error);
  CHECK(compare_all({}, simulated()).outcome.reasons.front() == "there is no recording");
}

TEST("the verdict of a group does not depend on the order of its recordings") {
  std::vector<Recording> all = subjects();
  all[0] = cut(all[0]);
  const GroupComparison forward = compare_all(all, simulated());
  std::ranges::reverse(all);
  const GroupComparison backward = compare_all(all, simulated());
  const std::vector<FeatureComparison>& a = forward.groups.front().means;
  const std::vector<FeatureComparison>& b = backward.groups.front().means;
  REQUIRE(a.size() == features_of(QuantityKind::pressure).size());
  REQUIRE(b.size() == a.size());
  for (std::size_t n = 0; n < a.size(); ++n) {
    CHECK(a[n].status == b[n].status);
    CHECK_NEAR(a[n].quantity.uncertainty, b[n].quantity.uncertainty,
               1e-9 * std::abs(b[n].quantity.uncertainty));
  }
  CHECK(forward.outcome.status == backward.outcome.status);
  CHECK(a[static_cast<std::size_t>(Feature::loss_of_resistance)].status == Status::pass);
}

TEST("two recordings of each subject leave the mean and the number of subjects") {
  std::vector<Recording> all = subjects();
  for (std::size_t n = 0; n < 5; ++n) {
    all[n].subject = std::to_string(n);
    all.push_back(all[n]);
  }
  const GroupSummary twice = compare_all(all, simulated()).groups.front();
  const GroupSummary once = lean(simulated()).groups.front();
  CHECK(once.subjects == 5);
  CHECK(twice.subjects == 5);
  CHECK(once.recordings == 5);
  CHECK(twice.recordings == 10);
  CHECK(twice.corridor->recordings == 10);
  const FeatureSummary& peak = summary(once, Feature::peak);
  CHECK(summary(twice, Feature::peak).count == 5);
  CHECK_NEAR(summary(twice, Feature::peak).deviation, peak.deviation, 1e-9 * peak.deviation);
  const auto uncertainty = [](const GroupSummary& group) {
    return group.means[static_cast<std::size_t>(Feature::peak)].quantity.uncertainty;
  };
  CHECK_NEAR(uncertainty(twice), uncertainty(once), 1e-9 * uncertainty(once));
  CHECK_NEAR(twice.corridor->factor, once.corridor->factor, 0.0);
  CHECK(twice.subjects_agree == once.subjects_agree);
  CHECK(twice.tally.passed == 2 * once.tally.passed);
  CHECK(twice.agree_interval.upper == once.agree_interval.upper);
}

CredibilityFactor find(const std::vector<CredibilityFactor>& all, const char* name) {
  const auto found = std::ranges::find(all, name, &CredibilityFactor::factor);
  REQUIRE(found != all.end());
  return *found;
}

GroupComparison compared(Recording::Kind kind, std::size_t count, Status status) {
  GroupComparison comparison{.outcome = {.status = status}};
  for (std::size_t n = 0; n < count; ++n) {
    comparison.recordings.push_back(
        {.recording = "r" + std::to_string(n), .kind = kind, .outcome = {.status = status}});
  }
  return comparison;
}

TEST("without evidence no factor is shown, and each has a reason") {
  const std::vector<CredibilityFactor> all = credibility({}, nullptr);
  CHECK(all.size() >= 12);
  for (const CredibilityFactor& factor : all) {
    CHECK(factor.shown == Shown::not_shown);
    CHECK(factor.evidence.starts_with("not shown: "));
    CHECK(factor.links.empty());
    CHECK(!factor.goal.empty());
  }
}

TEST("cases that pass show a factor, one that fails shows it in part, skipped ones do not count") {
  std::vector<Outcome> outcomes{{.name = "oscillator/order/rk4", .status = Status::pass},
                                {.name = "network/skip", .status = Status::skip}};
  const auto verification = [&] {
    return find(credibility(outcomes, nullptr), "numerical code verification");
  };
  CHECK(verification().shown == Shown::shown);
  CHECK(verification().links.size() == 1);
  outcomes.push_back({.name = "errata/summary", .status = Status::fail});
  CHECK(verification().shown == Shown::in_part);
  CHECK(verification().evidence == "1 of 2 cases hold");
  outcomes.erase(outcomes.begin());
  CHECK(verification().shown == Shown::not_shown);
}

TEST("measured recordings show what their verdict says, rebuilt ones neither add nor remove") {
  using enum Recording::Kind;
  GroupComparison one_subject = compared(measured, 3, Status::pass);
  for (Comparison& one : one_subject.recordings) { one.subject = "07"; }
  GroupComparison mixed = compared(measured, 1, Status::pass);
  mixed.recordings.push_back({.kind = reconstructed, .outcome = {.status = Status::fail}});
  mixed.outcome.status = Status::fail;
  mixed.groups = {{.recordings = 2, .measured = 1, .outcome = {.status = Status::fail}}};
  GroupComparison swapped = mixed;
  swapped.recordings[0].outcome.status = Status::fail;
  swapped.recordings[1].outcome.status = Status::pass;
  swapped.outcome.status = swapped.groups[0].outcome.status = Status::pass;
  // A group of measured recordings is judged as one: its members need not all agree.
  GroupComparison group = compared(measured, 4, Status::pass);
  group.recordings[3].outcome.status = Status::fail;
  group.groups = {{.recordings = 4, .measured = 4, .outcome = {.status = Status::pass}}};
  struct {
    GroupComparison found;
    const char* factor;
    Shown shown;
    const char* evidence = "";
  } const rows[] = {
      {one_subject, "test samples", Shown::in_part, "measured recordings: 3, of subjects: 1"},
      {compared(reconstructed, 8, Status::pass), "test samples", Shown::not_shown,
       "8 rebuilt from published values do not count"},
      {compared(reconstructed, 8, Status::pass), "output comparison", Shown::not_shown},
      {compared(measured, 3, Status::pass), "output comparison", Shown::shown},
      {compared(measured, 3, Status::pass), "test samples", Shown::shown},
      {compared(measured, 1, Status::inconclusive), "output comparison", Shown::in_part},
      {compared(measured, 1, Status::inconclusive), "test samples", Shown::in_part},
      {compared(measured, 3, Status::fail), "output comparison", Shown::not_shown},
      {mixed, "output comparison", Shown::shown},
      {swapped, "output comparison", Shown::not_shown},
      {group, "output comparison", Shown::shown},
  };
  for (const auto& row : rows) {
    const std::vector<CredibilityFactor> all = credibility({}, &row.found);
    CHECK(find(all, row.factor).shown == row.shown);
    CHECK_CONTAINS(find(all, row.factor).evidence, row.evidence);
  }
  CHECK(find(credibility({}, &one_subject), "test samples").evidence ==
        "measured recordings: 3, of subjects: 1");
}

}  // namespace PALPATE_FILE
