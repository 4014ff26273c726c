// SPDX-License-Identifier: MIT
#pragma once
/// Holds results against a baseline: what is the same to the bit needs no further look; what is not
/// finite or not whole fails before any norm is taken; then rounding, errors and costs, curves
/// (docs/gate.md).

#include <string>
#include <vector>

#include "validation/gate/baseline.hpp"
#include "validation/gate/change.hpp"

namespace palpate::gate {

struct CaseVerdict {
  std::string name{};
  std::string suite{};
  bool identical = false;         ///< every number and every sample
  std::vector<Change> changes{};  ///< of what is not the same, worst first

  [[nodiscard]] bool falls() const { return !changes.empty() && changes.front().falls(); }
  [[nodiscard]] bool better() const;  ///< something is, and nothing falls
};

struct Tally {
  int identical = 0;
  int unchanged = 0;  ///< but for rounding, or within what is allowed
  int better = 0;
  int fallen = 0;
};

struct Verdict {
  std::vector<CaseVerdict> cases{};  ///< in the order of the baseline, then what it lacks
  std::vector<std::string>
      faults{};  ///< of the comparison as a whole: nothing selected, other command

  [[nodiscard]] Tally tally() const;
  [[nodiscard]] bool holds() const {
    return faults.empty() && !cases.empty() && tally().fallen == 0;
  }
};

/// What a gate is to look at, beside the baseline.
struct Candidate {
  std::string command{};  ///< that made the results
  std::vector<Outcome> outcomes{};
};

/// `only`: names of cases; empty: all, on both sides. A case that stands on one side alone fails.
Verdict judge(const Baseline& baseline, const Candidate& candidate,
              const std::vector<std::string>& only = {});

/// One case against what was accepted; both as comparable() leaves them.
CaseVerdict judge_case(const AcceptedCase& accepted, const Outcome& now);

}  // namespace palpate::gate
