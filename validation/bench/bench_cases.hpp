// SPDX-License-Identifier: MIT
#pragma once
/// What `palpate bench` measures: cases of the suite "timing", which run one at a time.

#include <vector>

#include "validation/case.hpp"
#include "validation/timing/instruction_count.hpp"

namespace palpate::bench {

std::vector<Case> kernel_cases();
std::vector<Case> instruction_set_cases();
std::vector<Case> thread_cases();
std::vector<Case> skip_cases();
std::vector<Case> precision_cases();
std::vector<Case> needle_cases();
std::vector<Case> far_field_cases();
std::vector<Case> frontier_cases();
std::vector<Case> instruction_cases(const timing::InstructionCounter& counter);

/// Every one, in that order.
std::vector<Case> all_benches(const timing::InstructionCounter& counter);

/// The problem that mass-spring programs are compared with: n x n x n nodes of 1 g, 10 mm apart, 26
/// neighbours with 50 N/m and 0.05 N s/m, one face held, 0.1 N on the middle of the other.
Scene s26_scene(int n);

}  // namespace palpate::bench
