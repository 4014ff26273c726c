// SPDX-License-Identifier: MIT
#pragma once
/// The credibility factors of ASME V&V 40-2018 with the evidence that was produced.

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
  std::string goal{};  ///< what would be enough for a trainer
  Shown shown = Shown::not_shown;
  std::string evidence{};            ///< what there is, counted; "not shown" and why otherwise
  std::vector<std::string> links{};  ///< names of cases, or of recordings
};
std::string_view name_of(CredibilityFactor::Shown shown);  ///< "not shown", "in part", "shown"

/// From the outcomes of a validation (empty: none was run) and, if there is one, a comparison. A
/// factor that rests on cases is shown when all of them pass, in part when some do. Recordings that
/// were rebuilt from published values are no clinical evidence and leave the factors of validation
/// "not shown".
std::vector<CredibilityFactor> credibility(std::span<const Outcome> outcomes,
                                           const GroupComparison* comparison);

}  // namespace palpate::comparison
