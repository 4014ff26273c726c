// SPDX-License-Identifier: MIT
#pragma once
/// Faults planted in the candidate must turn verdicts red that are green without them.

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

/// How many of a fault's cases a test tries. The optimised build tries them all: verdicts are what
/// it is for. Under sanitizers, ten times slower, each fault is tried on the first case, unless
/// another fault has been through that one.
template <class Name> std::span<const Name> tried(std::span<const Name> names) {
#ifdef PALPATE_SANITIZED
  static std::set<std::string> seen;
  return names.first(!names.empty() && seen.insert(names.front()).second ? 1 : 0);
#else
  return names;
#endif
}

/// References are the same with and without a fault: computed once.
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

/// Red with the fault, green without; under sanitizers with the fault alone, which goes through the
/// same code.
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
