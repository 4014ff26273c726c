// SPDX-License-Identifier: MIT
#include "validation/comparison/credibility.hpp"

#include <algorithm>

#include "tests/check.hpp"

namespace {

using namespace palpate;
using namespace palpate::comparison;
using Shown = CredibilityFactor::Shown;

CredibilityFactor find(const std::vector<CredibilityFactor>& all, const std::string& name) {
  const auto found = std::ranges::find(all, name, &CredibilityFactor::factor);
  CHECK(found != all.end());
  return found == all.end() ? CredibilityFactor{} : *found;
}

Outcome outcome(const std::string& name, Status status) { return {.name = name, .status = status}; }

GroupComparison compared(Recording::Kind kind, std::size_t count, Verdict verdict) {
  GroupComparison comparison{.verdict = verdict};
  for (std::size_t n = 0; n < count; ++n) {
    comparison.recordings.push_back({.recording = "r" + std::to_string(n), .kind = kind, .verdict = verdict});
  }
  return comparison;
}

TEST("without evidence nothing is shown and every factor says why") {
  const std::vector<CredibilityFactor> all = credibility({}, nullptr);
  CHECK(all.size() >= 12);
  for (const CredibilityFactor& factor : all) {
    CHECK(factor.shown == Shown::not_shown);
    CHECK(factor.evidence.starts_with("not shown: ") && factor.links.empty());
    CHECK(!factor.goal.empty());
  }
}

TEST("cases that pass show a factor, one that fails shows it in part, skipped ones do not count") {
  const std::string factor = "numerical code verification";
  std::vector<Outcome> outcomes{outcome("oscillator/order/rk4", Status::pass),
                                outcome("network/skip", Status::skip)};
  CHECK(find(credibility(outcomes, nullptr), factor).shown == Shown::shown);
  CHECK(find(credibility(outcomes, nullptr), factor).links.size() == 1);
  outcomes.push_back(outcome("errata/summary", Status::fail));
  const CredibilityFactor half = find(credibility(outcomes, nullptr), factor);
  CHECK(half.shown == Shown::in_part && half.evidence == "1 of 2 cases hold");
  outcomes.erase(outcomes.begin());
  CHECK(find(credibility(outcomes, nullptr), factor).shown == Shown::not_shown);
}

TEST("three recordings of one subject are one subject") {
  GroupComparison found = compared(Recording::Kind::measured, 3, Verdict::agrees);
  for (Comparison& one : found.recordings) { one.subject = "07"; }
  const CredibilityFactor samples = find(credibility({}, &found), "test samples");
  CHECK(samples.shown == Shown::in_part);
  CHECK(samples.evidence == "measured recordings: 3, of subjects: 1");
}

TEST("recordings rebuilt from published values show nothing about patients") {
  const GroupComparison rebuilt = compared(Recording::Kind::reconstructed, 8, Verdict::agrees);
  const std::vector<CredibilityFactor> all = credibility({}, &rebuilt);
  CHECK(find(all, "test samples").shown == Shown::not_shown);
  CHECK(find(all, "test samples").evidence.find("8 rebuilt from published values do not count") !=
        std::string::npos);
  CHECK(find(all, "output comparison").shown == Shown::not_shown);
}

TEST("measured recordings show what their verdict says") {
  const GroupComparison good = compared(Recording::Kind::measured, 3, Verdict::agrees);
  CHECK(find(credibility({}, &good), "output comparison").shown == Shown::shown);
  CHECK(find(credibility({}, &good), "test samples").shown == Shown::shown);
  const GroupComparison open = compared(Recording::Kind::measured, 1, Verdict::not_distinguishable);
  CHECK(find(credibility({}, &open), "output comparison").shown == Shown::in_part);
  CHECK(find(credibility({}, &open), "test samples").shown == Shown::in_part);
  const GroupComparison bad = compared(Recording::Kind::measured, 3, Verdict::differs);
  CHECK(find(credibility({}, &bad), "output comparison").shown == Shown::not_shown);
}

TEST("rebuilt recordings in the same group neither lift nor spoil what measured ones show") {
  GroupComparison mixed = compared(Recording::Kind::measured, 1, Verdict::agrees);
  mixed.recordings.push_back({.kind = Recording::Kind::reconstructed, .verdict = Verdict::differs});
  mixed.verdict = Verdict::differs;
  mixed.groups = {{.recordings = 2, .measured = 1, .verdict = Verdict::differs}};
  CHECK(find(credibility({}, &mixed), "output comparison").shown == Shown::shown);
  mixed.recordings[0].verdict = Verdict::differs;
  mixed.recordings[1].verdict = mixed.verdict = mixed.groups[0].verdict = Verdict::agrees;
  CHECK(find(credibility({}, &mixed), "output comparison").shown == Shown::not_shown);
}

TEST("a group that was measured alone counts as one: its members need not all agree") {
  GroupComparison found = compared(Recording::Kind::measured, 4, Verdict::agrees);
  found.recordings[3].verdict = Verdict::differs;
  found.groups = {{.recordings = 4, .measured = 4, .verdict = Verdict::agrees}};
  CHECK(find(credibility({}, &found), "output comparison").shown == Shown::shown);
}

}  // namespace
