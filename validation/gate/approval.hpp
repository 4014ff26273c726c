// SPDX-License-Identifier: MIT
#pragma once
/// Takes results as what later ones are held against.

#include <map>
#include <string>
#include <vector>

#include "validation/gate/baseline.hpp"

namespace palpate::gate {

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

/// A case without new variants keeps the spread that it had. Throws InputError where a case ended in an error or
/// a number is not finite: nothing like that may become what others are held against.
Baseline accept(const Baseline& old, const Acceptance& acceptance);

/// A line for every number that an approval changes: what it was, what it becomes, and the bound it is judged
/// by; and for every case that comes or goes.
std::vector<std::string> described_changes(const Baseline& old, const Baseline& updated);

}  // namespace palpate::gate
