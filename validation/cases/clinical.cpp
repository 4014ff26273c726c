// SPDX-License-Identifier: MIT
#include <algorithm>
#include <iterator>

#include "validation/cases/clinical_parts.hpp"
#include "validation/cases/groups.hpp"

namespace palpate {

std::vector<Case> clinical_cases() {
  std::vector<Case> cases;
  for (const auto part : {clinical::measure_cases, clinical::feature_cases, clinical::verdict_cases,
                          clinical::detection_cases, clinical::subject_cases,
                          clinical::round_trip_cases, clinical::calibration_cases}) {
    std::ranges::move(part(), std::back_inserter(cases));
  }
  return cases;
}

}  // namespace palpate
