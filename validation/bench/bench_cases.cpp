// SPDX-License-Identifier: MIT
#include "validation/bench/bench_cases.hpp"

#include <algorithm>
#include <iterator>

namespace palpate::bench {

std::vector<Case> all_benches(const timing::InstructionCounter& counter) {
  std::vector<Case> cases = kernel_cases();
  std::ranges::move(instruction_set_cases(), std::back_inserter(cases));
  std::ranges::move(thread_cases(), std::back_inserter(cases));
  std::ranges::move(skip_cases(), std::back_inserter(cases));
  std::ranges::move(precision_cases(), std::back_inserter(cases));
  std::ranges::move(needle_cases(), std::back_inserter(cases));
  std::ranges::move(far_field_cases(), std::back_inserter(cases));
  std::ranges::move(frontier_cases(), std::back_inserter(cases));
  std::ranges::move(instruction_cases(counter), std::back_inserter(cases));
  return cases;
}

}  // namespace palpate::bench
