// SPDX-License-Identifier: MIT
#include <algorithm>
#include <iterator>

#include "validation/cases/groups.hpp"
#include "validation/cases/network_parts.hpp"

namespace palpate {

std::vector<Case> network_cases() {
  using namespace networks;
  std::vector<Case> cases;
  for (const auto part : {elasticity_cases, wave_cases, skew_cases, momentum_cases, energy_cases,
                          work_cases, invariance_cases, block_cases, order_cases, load_cases,
                          kernel_cases, manufactured_cases, approximation_cases}) {
    std::ranges::move(part(), std::back_inserter(cases));
  }
  return cases;
}

}  // namespace palpate
