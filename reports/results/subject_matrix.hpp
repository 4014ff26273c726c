// SPDX-License-Identifier: MIT
#pragma once
/// Comparison of several simulators: their results on the same cases.

#include <vector>

#include "reports/results/results.hpp"

namespace palpate {

/// Returns one outcome with the matrix of verdicts, the coverage, and the cost at equal error of
/// S26. Each element is the results of one subject; its name is the entry "subject" of the
/// provenance, and the model of this project has none.
Results subject_matrix(const std::vector<Results>& subjects);

}  // namespace palpate
