// SPDX-License-Identifier: MIT
#include <algorithm>
#include <iterator>

#include "validation/cases/groups.hpp"
#include "validation/cases/oscillator_parts.hpp"

namespace palpate {

std::vector<Case> oscillator_cases() {
  using namespace oscillator;
  std::vector<Case> cases;
  for (const auto part : {order_cases, discrete_cases, stability_limit_cases, regime_cases,
                          figure_cases, phase_cases, comparison_cases, sweep_cases}) {
    std::ranges::move(part(), std::back_inserter(cases));
  }
  return cases;
}

}  // namespace palpate
