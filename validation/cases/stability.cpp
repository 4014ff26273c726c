// SPDX-License-Identifier: MIT
#include "validation/cases/stability.hpp"

#include "validation/cases/groups.hpp"

namespace palpate {

std::vector<Case> stability_cases() {
  std::vector<Case> cases;
  stability::add_blow_up_cases(cases);
  stability::add_bound_cases(cases);
  stability::add_map_cases(cases);
  return cases;
}

}  // namespace palpate
