// SPDX-License-Identifier: MIT
#pragma once
/// Tool part of `palpate inspect`: a needle or a probe.

#include <nlohmann/json.hpp>

#include "model/problem/problem.hpp"

namespace palpate::cli {

/// Returns the keys "tool", "static_compliance_m_per_n" and, if that is null,
/// "static_compliance_reason". Empty for a scene without a tool.
nlohmann::ordered_json tool_inspection(const Scene& scene, const NetworkProblem& problem);

/// Prints the same data as text: one key of "tool" per line, and the needle path as a table.
void print_tool(const nlohmann::ordered_json& tool);

}  // namespace palpate::cli
