// SPDX-License-Identifier: MIT

#include "validation/case.hpp"

#include <algorithm>
#include <chrono>

#include "model/problem/input_error.hpp"
#include "validation/claims/groups.hpp"

namespace palpate {

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  for (const auto group :
       {oscillator_cases, errata_cases, network_cases, patient_cases, stability_cases, tool_cases,
        haptic_cases, clinical_cases, certificate_cases, gate_cases}) {
    std::ranges::move(group(), std::back_inserter(cases));
  }
  return cases;
}

std::vector<Case> select_cases(const std::vector<Case>& cases,
                               std::span<const std::string> patterns, bool quick) {
  const auto matches = [](const Case& one, const std::string& pattern) {
    return one.name == pattern || one.name.starts_with(pattern + "/") || one.suite == pattern;
  };
  for (const std::string& pattern : patterns) {
    if (std::ranges::none_of(cases, [&](const Case& one) { return matches(one, pattern); })) {
      throw InputError("no case is named \"" + pattern + "\"; validate --list shows them all");
    }
  }
  std::vector<Case> selected;
  for (const Case& one : cases) {
    const bool named = std::ranges::any_of(
        patterns, [&](const std::string& pattern) { return matches(one, pattern); });
    if (patterns.empty() ? one.quick || !quick : named) { selected.push_back(one); }
  }
  if (selected.empty()) { throw InputError("the selection holds no case; at least one"); }
  return selected;
}

Outcome run_case(const Case& definition, const CaseContext& context) {
  Outcome outcome;
  outcome.name = definition.name;
  outcome.suite = definition.suite;
  outcome.claim = definition.claim;
  const auto begin = std::chrono::steady_clock::now();
  try {
    definition.measure(context, outcome);
    conclude(outcome);
  } catch (const std::exception& problem) {
    outcome.status = Status::error;
    outcome.reasons = {problem.what()};
  }
  outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return outcome;
}

}  // namespace palpate
