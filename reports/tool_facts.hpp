// SPDX-License-Identifier: MIT
#pragma once
/// What people ask first about a run with a tool, and what happened in it.

#include <vector>

#include "model/dynamics/trace.hpp"
#include "reports/html_page.hpp"

namespace palpate {

/// Deepest place, peak force and where, loss of resistance, peak pressure; empty without a tool.
std::vector<Fact> tool_facts(const Trace& trace);

/// Events in order of time; with a tool also its depth, and the force one tick before and at the
/// event.
Table events_table(const Trace& trace);

}  // namespace palpate
