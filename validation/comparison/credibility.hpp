// SPDX-License-Identifier: MIT
#pragma once
/// Credibility factors of ASME V&V 40-2018 and the available evidence.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "validation/comparison/group_comparison.hpp"
#include "validation/outcome.hpp"

namespace palpate::comparison {

struct CredibilityFactor {
  enum class Shown { not_shown, in_part, shown };
  std::string activity{};  ///< verification, validation or applicability
  std::string factor{};
  std::string goal{};  ///< sufficient evidence for a training simulator
  Shown shown = Shown::not_shown;
  std::string evidence{};  ///< available evidence with counts; "not shown" and why otherwise
  std::vector<std::string> links{};  ///< names of cases or recordings
};
std::string_view name_of(CredibilityFactor::Shown shown);  ///< "not shown", "in part", "shown"

/// Returns the factors from the outcomes of a validation (empty: not run) and an optional
/// comparison. A factor that depends on cases is shown if all of them pass, in part if some do.
/// Recordings that were reconstructed from published values are no clinical evidence and leave the
/// factors of validation "not shown".
std::vector<CredibilityFactor> credibility(std::span<const Outcome> outcomes,
                                           const GroupComparison* comparison);

}  // namespace palpate::comparison
