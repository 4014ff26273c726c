// SPDX-License-Identifier: MIT
#pragma once
/// Compares results with a baseline (docs/gate.md). Equal bits pass at once; what is not finite or
/// incomplete fails before any norm is computed; then come rounding, errors and costs, and curves.

#include <string>
#include <vector>

#include "validation/gate/baseline.hpp"
#include "validation/gate/change.hpp"

namespace palpate::gate {

/// One case compared with its baseline.
struct CaseChanges {
  Outcome outcome{};              ///< that the case is not worse; reasons are the changes that fail
  bool identical = false;         ///< every number and every sample
  std::vector<Change> changes{};  ///< everything that is not the same, worst first

  [[nodiscard]] bool fails() const { return outcome.status == Status::fail; }
  [[nodiscard]] bool better() const;  ///< something became better, and nothing fails
};

/// Numbers of cases by how they changed.
struct ChangeCounts {
  int identical = 0;
  int unchanged = 0;  ///< changed by rounding, or within what is allowed
  int better = 0;
  int failed = 0;
};

struct GateResult {
  std::vector<CaseChanges> cases{};  ///< in the order of the baseline, then those it lacks
  /// Why the comparison as a whole is not valid: nothing selected, results of another command.
  std::vector<std::string> faults{};

  [[nodiscard]] ChangeCounts counts() const;
  /// The verdict: error with faults, fail with a case that fails.
  [[nodiscard]] Outcome outcome() const;
  /// One outcome for each fault, then that of each case.
  [[nodiscard]] std::vector<Outcome> outcomes() const;
  [[nodiscard]] bool holds() const { return outcome().status == Status::pass; }
};

/// The results that a gate compares with the baseline.
struct Candidate {
  std::string command{};  ///< that made the results
  std::vector<Outcome> outcomes{};
};

/// `only`: names of cases; empty: all, on both sides. A case that is on one side alone fails.
GateResult compare(const Baseline& baseline, const Candidate& candidate,
                   const std::vector<std::string>& only = {});

/// One case compared with the accepted one; both as comparable() returns them.
CaseChanges compare_case(const AcceptedCase& accepted, const Outcome& now);

}  // namespace palpate::gate
