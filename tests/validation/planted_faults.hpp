// SPDX-License-Identifier: MIT
#pragma once
/// Tests that faults planted in the candidate fail the verdicts that pass without them.

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <initializer_list>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "tests/check.hpp"
#include "validation/case.hpp"

namespace palpate {

/// Cases of a fault that a test runs. The optimised build runs all cases. With sanitizers, which
/// are ten times slower, each fault runs only the first case, unless another fault already covers
/// it.
template <class Name> std::span<const Name> tried(std::span<const Name> names) {
#ifdef PALPATE_SANITIZED
  static std::set<std::string> seen;
  return names.first(!names.empty() && seen.insert(names.front()).second ? 1 : 0);
#else
  return names;
#endif
}

/// Cache of references. They do not depend on the faults and are computed once.
inline const reference::Cache& shared_references() {
  static std::map<std::string, Trace> kept;
  static const reference::Cache cache{
      .load = [](const std::string& key) -> std::optional<Trace> {
        const auto found = kept.find(key);
        return found == kept.end() ? std::nullopt : std::optional(found->second);
      },
      .save = [](const std::string& key, const Trace& solution) { kept.emplace(key, solution); }};
  return cache;
}

inline void check_status(const std::string& name, const Mutation* mutation, Status expected) {
  const std::vector<std::string> patterns{name};
  const CaseContext context{.quick = true, .mutation = mutation, .cache = &shared_references()};
  const Outcome outcome = run_case(select_cases(all_cases(), patterns, true).front(), context);
  if (outcome.status != expected) {
    std::printf("  %s is %s %s %s\n", name.c_str(), name_of(outcome.status).data(),
                mutation != nullptr ? mutation->name.c_str() : "", outcome.reason().c_str());
    for (const Quantity& q : outcome.quantities) {
      if (!q.holds()) { std::printf("    %s = %g\n", q.name.c_str(), q.value); }
    }
  }
  CHECK(outcome.status == expected);
}

/// Checks that the verdicts fail with the fault and pass without it. With sanitizers only the run
/// with the fault is checked, since it executes the same code.
inline void check_red(const Mutation& mutation, std::initializer_list<const char*> names) {
  for (const char* name : tried(std::span<const char* const>(names))) {
    check_status(name, &mutation, Status::fail);
#ifndef PALPATE_SANITIZED
    static std::set<std::string> green;
    if (green.insert(name).second) { check_status(name, nullptr, Status::pass); }
#endif
  }
}

}  // namespace palpate
