// SPDX-License-Identifier: MIT
#pragma once
/// Accepted results with which a gate compares new results (docs/gate.md).

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "validation/outcome.hpp"

namespace palpate::gate {

/// Effect of rounding on the numbers of a case: the largest difference between runs of the same
/// code with another order of springs, another instruction set or another optimisation.
struct Spread {
  std::map<std::string, double> quantities{};  ///< by name [unit of the quantity]
  std::map<std::string, double> curves{};      ///< by curve_name() [unit of the figure's y]
  int runs = 0;  ///< number of runs that were compared; 0: never measured
};

struct AcceptedCase {
  Outcome outcome{};  ///< only the deterministic parts, see comparable()
  Spread spread{};
};

/// Entry of the ledger: cases that were accepted, date and reason.
struct Approval {
  std::string date{};    ///< UTC, ISO 8601
  std::string commit{};  ///< commit of the program that produced the results
  std::string reason{};
  std::vector<std::string> cases{};
};

struct Baseline {
  std::string command{};  ///< command line that made the results
  std::map<std::string, std::string> provenance{};
  std::vector<AcceptedCase> cases{};
  std::vector<Approval> ledger{};
  std::filesystem::path curves{};  ///< file that the samples were read from; empty: none

  [[nodiscard]] const AcceptedCase* find(const std::string& name) const;
};

/// Returns the parts of an outcome that two runs of one program on one input share. Run times,
/// tables and notes are removed, except the compared texts; in suite "timing" only the counted
/// quantities remain (is_counted()).
Outcome comparable(Outcome outcome);

// Texts that a gate compares, such as the kernel of a run, are a table of an outcome: two columns,
// name and text.

inline constexpr std::string_view text_table = "compared-texts";
/// Text of a warning that only some runs of the same code give.
inline constexpr std::string_view depends_on_rounding = "not compared: depends on rounding";
/// Beginnings of the names of texts that are keys of the scene, and warnings.
inline constexpr std::string_view scene_prefix = "scene: ";
inline constexpr std::string_view warning_prefix = "warning: ";
/// Beginning of the warning with the estimated error of the reduced-order model. It is not
/// compared, because a run with --no-skip, which is exact, does not have it.
inline constexpr std::string_view reduction_warning = "warning: the reduced-order model changes";
/// Beginning of the names of quantities that are the times of events, in their order.
inline constexpr std::string_view event_prefix = "event: ";

/// Returns the compared texts of an outcome by name.
std::map<std::string, std::string> compared_texts(const Outcome& outcome);

/// Returns true if a commit names a tree with uncommitted changes, whose build cannot be repeated.
inline bool is_dirty(const std::string& commit) { return commit.ends_with("-dirty"); }

/// Returns true for units of counts, which are exactly reproducible: instructions, evaluations,
/// digits.
bool is_counted(const std::string& unit);

/// Returns the name of a curve, "error-over-step: leapfrog"; a number is added if two series of a
/// figure share a label.
std::string curve_name(const Figure& figure, std::size_t series);

/// Returns the largest differences of `variants` from `accepted` and from each other, by case.
/// Every variant must contain the same cases, quantities and curves. Throws InputError.
void measure_spread(Baseline& baseline, const std::vector<std::vector<Outcome>>& variants);

// Approval of results as the baseline of later results.

struct Acceptance {
  std::string command{};                            ///< command line that made the results
  std::map<std::string, std::string> provenance{};  ///< of the results
  std::string date{};                               ///< of the approval
  std::string reason{};
  std::vector<Outcome> outcomes{};
  std::vector<std::string>
      only{};  ///< names; empty: all, and cases missing in the results are removed
  std::vector<std::string> failing{};  ///< names of cases that may be accepted although they fail
  /// Results of the same cases from other builds or orders of summation, for Spread.
  std::vector<std::vector<Outcome>> variants{};
};

/// Accepts results. A case without new variants keeps its previous spread. Throws InputError if a
/// case ended in an error, a number is not finite, or a case fails that `failing` does not name.
Baseline accept(const Baseline& old, const Acceptance& acceptance);

/// Returns one line for each number that an approval changes (old value, new value, bound), for
/// each case that is added or removed, and for each that is accepted although it fails.
std::vector<std::string> described_changes(const Baseline& old, const Baseline& updated);

}  // namespace palpate::gate
