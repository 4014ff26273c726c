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

}  // namespace
