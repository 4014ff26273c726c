// SPDX-License-Identifier: MIT
#pragma once
/// What was accepted once, and what a change is held against (docs/gate.md).

#include <map>
#include <string>
#include <vector>

#include "validation/outcome.hpp"

namespace palpate::gate {

/// How far rounding alone moves what a case finds: the largest difference between runs of the same
/// code with springs in another order, other instructions, another optimisation.
struct Spread {
  std::map<std::string, double> quantities{};  ///< by name [unit of the quantity]
  std::map<std::string, double> curves{};      ///< by curve_name() [unit of the figure's y]
  int runs = 0;                                ///< that were compared; 0: never measured
};

struct AcceptedCase {
  Outcome outcome{};  ///< deterministic parts alone, see comparable()
  Spread spread{};
};

/// One line of the ledger: who reads it wants to know why numbers moved.
struct Approval {
  std::string date{};    ///< UTC, ISO 8601
  std::string commit{};  ///< of the program that found them
  std::string reason{};
  std::vector<std::string> cases{};
};

struct Baseline {
  std::string command{};  ///< that made the results, with its options
  std::map<std::string, std::string> provenance{};
  std::vector<AcceptedCase> cases{};
  std::vector<Approval> ledger{};

  [[nodiscard]] const AcceptedCase* find(const std::string& name) const;
};

/// What two runs of one program on one input have in common: no run times, no tables or notes, and
/// of suite "timing" the counted quantities alone (is_counted()).
Outcome comparable(Outcome outcome);

/// Units of what is counted and so repeats to the last digit: instructions, evaluations, digits.
bool is_counted(const std::string& unit);

/// "error-over-step: leapfrog", with a number where two series of a figure share a label.
std::string curve_name(const Figure& figure, std::size_t series);

/// Largest differences of `variants` from `accepted` and from each other, by case. Every variant
/// must hold the same cases, quantities and curves. Throws InputError.
void measure_spread(Baseline& baseline, const std::vector<std::vector<Outcome>>& variants);

// Takes results as what later ones are held against.

struct Acceptance {
  std::string command{};                            ///< that made the results
  std::map<std::string, std::string> provenance{};  ///< of the results
  std::string date{};                               ///< of the approval
  std::string reason{};
  std::vector<Outcome> outcomes{};
  std::vector<std::string> only{};  ///< names; empty: all, and what the results lack is dropped
  /// The same cases by other builds or orders of summation, for Spread.
  std::vector<std::vector<Outcome>> variants{};
};

/// A case without new variants keeps the spread that it had. Throws InputError where a case ended
/// in an error or a number is not finite: nothing like that may become what others are held
/// against.
Baseline accept(const Baseline& old, const Acceptance& acceptance);

/// A line for every number that an approval changes: what it was, what it becomes, and the bound it
/// is judged by; and for every case that comes or goes.
std::vector<std::string> described_changes(const Baseline& old, const Baseline& updated);

}  // namespace palpate::gate
