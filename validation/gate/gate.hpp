// SPDX-License-Identifier: MIT
#pragma once
/// Comparison of results with a baseline (docs/gate.md). Bitwise equal results pass. Results that
/// are not finite or incomplete fail before any norm is computed. Then rounding, errors, costs and
/// curves are compared.

#include <string>
#include <vector>

#include "validation/gate/baseline.hpp"
#include "validation/gate/change.hpp"

namespace palpate::gate {

/// One case compared with its baseline.
struct CaseChanges {
  Outcome outcome{};  ///< verdict that the case is not worse; reasons are the changes that fail
  bool identical = false;         ///< every number and every sample is equal
  std::vector<Change> changes{};  ///< all differences, worst first

  [[nodiscard]] bool fails() const { return outcome.status == Status::fail; }
  [[nodiscard]] bool better() const;  ///< at least one improvement and no failure
};

/// Numbers of cases by how they changed.
struct ChangeCounts {
  int identical = 0;
  int unchanged = 0;  ///< changed by rounding, or within the limits
  int better = 0;
  int failed = 0;
};

struct GateResult {
  std::vector<CaseChanges> cases{};  ///< in the order of the baseline, then those it lacks
  /// Reasons why the comparison as a whole is not valid: nothing selected, results of another
  /// command.
  std::vector<std::string> faults{};

  [[nodiscard]] ChangeCounts counts() const;
  /// Returns the verdict: error if there are faults, fail if a case fails.
  [[nodiscard]] Outcome outcome() const;
  /// Returns one outcome for each fault, then that of each case.
  [[nodiscard]] std::vector<Outcome> outcomes() const;
  [[nodiscard]] bool holds() const { return outcome().status == Status::pass; }
};

/// The results that a gate compares with the baseline.
struct Candidate {
  std::string command{};  ///< command line that produced the results
  std::vector<Outcome> outcomes{};
};

/// Compares a candidate with a baseline. `only` selects cases by name on both sides; empty: all. A
/// case that is on one side only fails.
GateResult compare(const Baseline& baseline, const Candidate& candidate,
                   const std::vector<std::string>& only = {});

/// Compares one case with the accepted one; both as comparable() returns them.
CaseChanges compare_case(const AcceptedCase& accepted, const Outcome& now);

}  // namespace palpate::gate
