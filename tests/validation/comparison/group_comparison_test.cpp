// SPDX-License-Identifier: MIT
#include "validation/comparison/group_comparison.hpp"

#include <algorithm>

#include "tests/check.hpp"
#include "validation/cases/clinical_traces.hpp"

namespace {

using namespace palpate;
using namespace palpate::comparison;
using clinical::PressureLaw;

const std::vector<double> time_of_link = clinical::instants(14.0, 120.0);
const std::vector<double> ticks = clinical::instants(14.0, 1000.0);

/// A subject whose pressures are all larger by a factor.
Recording subject(double factor, const std::string& group) {
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

std::vector<Recording> subjects(const std::string& group) {
  std::vector<Recording> all;
  for (const double factor : {0.8, 0.9, 1.0, 1.1, 1.2}) { all.push_back(subject(factor, group)); }
  return all;
}

TEST("an insertion in the middle of its subjects agrees with the group though not with each of them") {
  const GroupComparison found = compare_all(subjects("lean"), simulated());
  CHECK(found.groups.size() == 1);
  const GroupSummary& group = found.groups.front();
  CHECK(group.corridor && group.coverage.holds);
  CHECK(group.differ > 0 && group.agree > 0);
  CHECK(group.recordings == 5 && group.measured == 0);
  // 79 % of the peak tolerance is left after the spread of a mean of five: undecided or agreed, never
  // different
  CHECK(group.verdict != Verdict::differs && group.verdict != Verdict::not_comparable);
}

TEST("means and spreads over subjects by hand") {
  const GroupComparison found = compare_all(subjects("lean"), simulated());
  const FeatureSummary& peak = found.groups.front().features[static_cast<std::size_t>(Feature::peak)];
  const double middle = *found.recordings[2].recorded_features[Feature::peak].value;  // the factor 1
  CHECK(peak.count == 5);
  CHECK_NEAR(peak.mean, middle, 1e-9 * middle);
  CHECK_NEAR(peak.deviation, middle * std::sqrt(0.1 / 4.0), 1e-9 * middle);
  CHECK(peak.interval && peak.interval->holds(peak.mean));
}

TEST("the spread of a mean over subjects is part of its uncertainty") {
  std::vector<double> louder = clinical::pressures({}, ticks);
  for (double& p : louder) { p *= 1.15; }
  // Off by 15 % where 10.2 % are allowed, but the mean of five is known to 2 x 15.8 % / sqrt(5) = 14 %.
  CHECK(compare_all(subjects("lean"), clinical::trace_of(ticks, louder)).verdict ==
        Verdict::not_distinguishable);
}

TEST("features that agree do not save a trace that leaves the corridor") {
  std::vector<double> odd = clinical::pressures({}, ticks);
  for (std::size_t n = 0; n < 2500; ++n) { odd[n] += 30.0 * pascals_per_mmhg; }  // long before the event
  const GroupComparison found = compare_all(subjects("lean"), clinical::trace_of(ticks, odd));
  CHECK(found.recordings[2].verdict ==
        Verdict::agrees);  // by features alone, against the subject of factor 1
  CHECK(found.verdict == Verdict::differs);
  CHECK(found.groups.front().coverage.inside < 0.9 && found.groups.front().coverage.inside > 0.7);
}

TEST("a simulation that ends before its event can be called so leaves the group open") {
  std::vector<double> until = clinical::instants(8.5, 1000.0);
  const Trace cut = clinical::trace_of(until, clinical::pressures({}, until));
  const GroupComparison found = compare_all(subjects("lean"), cut);
  CHECK(found.verdict == Verdict::not_distinguishable);
  CHECK(found.reasons.front().find("the trace ends") != std::string::npos);
}

TEST("a first recording with a gap over its fall hides nothing of the others") {
  std::vector<Recording> all = subjects("lean");
  for (std::size_t n = 0; n < all[0].time.size(); ++n) {
    if (all[0].time[n] > 6.05 && all[0].time[n] < 6.25) { all[0].pressure[n] = not_measured; }
  }
  const GroupComparison found = compare_all(all, simulated({.fall_constant = 0.75}));
  CHECK(found.groups.front().features[static_cast<std::size_t>(Feature::drop_time)].count == 4);
  bool told = false;
  for (const std::string& reason : found.reasons) {
    told = told || reason.find("drop time") != std::string::npos;
  }
  CHECK(told && found.verdict == Verdict::differs);
}

TEST("an insertion without the event differs from the group and leaves its corridor") {
  const GroupComparison found = compare_all(subjects("lean"), simulated({.plateau = PressureLaw{}.peak}));
  CHECK(found.verdict == Verdict::differs);
  CHECK(!found.groups.front().coverage.holds);
  CHECK(found.reasons.front().find("in the corridor of 5 subjects") != std::string::npos);
}

TEST("two recordings have no corridor; they are judged one by one") {
  const std::vector<Recording> two{subject(1.0, "a"), subject(1.5, "a")};
  const GroupComparison found = compare_all(two, simulated());
  CHECK(!found.groups.front().corridor);
  CHECK(found.groups.front().corridor_refusal == "a corridor needs at least 3 subjects; there are 2");
  CHECK(found.verdict == Verdict::differs);
  CHECK(!found.groups.front().features.front().interval);
}

TEST("groups are summed up apart, in the order of their first recordings") {
  std::vector<Recording> all = subjects("lean");
  all.insert(all.begin() + 1, subject(2.0, "heavy"));
  const GroupComparison found = compare_all(all, simulated());
  CHECK(found.groups.size() == 2 && found.groups[0].group == "lean" && found.groups[1].group == "heavy");
  CHECK(found.groups[0].recordings == 5 && found.groups[1].recordings == 1);
  CHECK(found.verdict == Verdict::differs);
}

TEST("what cannot be compared is counted and left out") {
  std::vector<Recording> all = subjects("lean");
  all[3].regime = Recording::Regime::pump;
  const GroupSummary group = compare_all(all, simulated()).groups.front();
  CHECK(group.not_comparable == 1 && group.corridor->recordings == 4);
  const std::vector<Recording> none{all[3]};
  CHECK(compare_all(none, simulated()).verdict == Verdict::not_comparable);
  CHECK(compare_all({}, simulated()).reasons.front() == "there is no recording");
}

/// With both traces cut before the event can be called so, for a recording of the factor.
Recording cut(Recording recording) {
  while (recording.time.back() > 8.5) {
    recording.time.pop_back();
    recording.pressure.pop_back();
  }
  return recording;
}

TEST("two traces that both end before the event can be called so do not agree") {
  const std::vector<double> until = clinical::instants(8.5, 1000.0);
  const Trace trace = clinical::trace_of(until, clinical::pressures({}, until));
  const GroupComparison found = compare_all(std::vector<Recording>{cut(subject(1.0, "lean"))}, trace);
  CHECK(found.verdict == Verdict::not_distinguishable);
  CHECK(found.reasons.front().find("loss of resistance: in neither: the trace ends") != std::string::npos);
}

TEST("the verdict of a group does not depend on who comes first") {
  std::vector<Recording> all = subjects("lean");
  all[0] = cut(all[0]);
  const GroupComparison forward = compare_all(all, simulated());
  std::ranges::reverse(all);
  const GroupComparison backward = compare_all(all, simulated());
  const std::vector<FeatureVerdict>& a = forward.groups.front().means;
  const std::vector<FeatureVerdict>& b = backward.groups.front().means;
  CHECK(a.size() == feature_count && b.size() == feature_count);
  for (std::size_t n = 0; n < a.size(); ++n) {
    CHECK(a[n].verdict == b[n].verdict);
    CHECK_NEAR(a[n].expanded, b[n].expanded, 1e-9 * std::abs(b[n].expanded));
  }
  CHECK(forward.verdict == backward.verdict);
  CHECK(a[static_cast<std::size_t>(Feature::loss_of_resistance)].verdict == Verdict::agrees);
}

TEST("two recordings of each subject leave the mean and the number of subjects") {
  std::vector<Recording> all = subjects("lean");
  for (std::size_t n = 0; n < 5; ++n) {
    all[n].subject = std::to_string(n);
    all.push_back(all[n]);
  }
  const GroupSummary twice = compare_all(all, simulated()).groups.front();
  const GroupSummary once = compare_all(subjects("lean"), simulated()).groups.front();
  CHECK(twice.subjects == 5 && twice.recordings == 10 && twice.corridor->recordings == 10);
  CHECK(once.subjects == 5 && once.recordings == 5);
  const auto n = static_cast<std::size_t>(Feature::peak);
  CHECK(twice.features[n].count == 5);
  CHECK_NEAR(twice.features[n].deviation, once.features[n].deviation, 1e-9 * once.features[n].deviation);
  CHECK_NEAR(twice.means[n].expanded, once.means[n].expanded, 1e-9 * once.means[n].expanded);
  CHECK_NEAR(twice.corridor->factor, once.corridor->factor, 0.0);
  CHECK(twice.subjects_agree == once.subjects_agree && twice.agree == 2 * once.agree);
  CHECK(twice.agree_interval.upper == once.agree_interval.upper);
}

}  // namespace
