// SPDX-License-Identifier: MIT
#pragma once
/// The part of `palpate inspect` about a needle or a probe.

#include <nlohmann/json.hpp>

#include "model/problem/problem.hpp"

namespace palpate::cli {

/// Keys "tool", "static_compliance_m_per_n" and, if that is null, "static_compliance_reason";
/// empty for a scene without a tool.
nlohmann::ordered_json tool_inspection(const Scene& scene, const NetworkProblem& problem);

/// The same for people to read: the keys of "tool" one a line, the line of a needle as a table.
void print_tool(const nlohmann::ordered_json& tool);

}  // namespace palpate::cli
