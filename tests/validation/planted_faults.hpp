// SPDX-License-Identifier: MIT
#pragma once
/// Tests that faults planted in the candidate fail the verdicts that pass without them.

#include <algorithm>
#include <map>
#include <set>

#include "fixtures/io/scene_file.hpp"
#include "tests/check.hpp"
#include "validation/case.hpp"
#include "validation/planted_faults.hpp"

namespace palpate {

/// Fault and the cases of a group that must fail with it.
struct Planted {
  Mutation fault{};
  std::vector<std::string> cases{};
};

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
  // A drawn scene can hide a fault behind the error that its verdict allows; this one does not.
  CaseContext context{
      .quick = true, .seed = 11, .mutation = mutation, .cache = &shared_references()};
  context.shipped_scene = [](std::string_view shipped) -> std::optional<Scene> {
    const auto folder = scratch::source_folder() / "fixtures" / "scenes";
    return io::read_scene(folder / (std::string(shipped) + ".toml")).scene;
  };
  const Outcome outcome = run_case(select_cases(all_cases(), patterns, true).front(), context);
  if (outcome.status != expected) {
    std::printf("  %s is %s with \"%s\": %s\n", name.c_str(), name_of(outcome.status).data(),
                mutation != nullptr ? mutation->name.c_str() : "", outcome.reason().c_str());
    for (const Quantity& q : outcome.quantities) {
      if (!q.holds()) { std::printf("    %s = %g\n", q.name.c_str(), q.value); }
    }
  }
  CHECK(outcome.status == expected);
}

/// Checks that the case passes without a fault. It runs once, however many faults name it.
inline void check_green(const std::string& name) {
  static std::set<std::string> green;
  if (green.insert(name).second) { check_status(name, nullptr, Status::pass); }
}

/// Checks that the cases fail with the fault and pass without it; `group` begins their names. With
/// sanitizers, which are ten times slower, each fault runs one case, the first that no
/// fault before it runs, and the run without the fault, which executes the same code, is left
/// out.
inline void check_red(const std::string& group, const std::vector<Planted>& faults) {
  [[maybe_unused]] std::set<std::string> covered;
  for (const auto& [fault, cases] : faults) {
#ifdef PALPATE_SANITIZED
    const auto fresh = std::ranges::find_if_not(
        cases, [&](const std::string& name) { return covered.contains(name); });
    const std::string& name = fresh == cases.end() ? cases.front() : *fresh;
    covered.insert(name);
    check_status(group + name, &fault, Status::fail);
#else
    for (const std::string& name : cases) {
      check_green(group + name);
      check_status(group + name, &fault, Status::fail);
    }
#endif
  }
}

}  // namespace palpate
