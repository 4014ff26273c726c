// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "model/problem/problem.hpp"

namespace palpate::cli {

/// Static compliance of the tissue at the tool [m/N]. Empty without a tool, for too many nodes and
/// for tissue that can move freely.
std::optional<double> tool_compliance(const Scene& scene, const NetworkProblem& problem);

}  // namespace palpate::cli
