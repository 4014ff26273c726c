// SPDX-License-Identifier: MIT
#include "validation/cases/stability.hpp"

#include "validation/cases/groups.hpp"

namespace palpate {

std::vector<Case> stability_cases() {
  std::vector<Case> cases;
  stability::add_blow_up_cases(cases);
  stability::add_bound_cases(cases);
  stability::add_map_cases(cases);
  stability::add_contrast_cases(cases);
  stability::add_abuse_cases(cases);
  stability::add_step_cases(cases);
  stability::add_denormal_cases(cases);
  stability::add_drift_cases(cases);
  return cases;
}

}  // namespace palpate
