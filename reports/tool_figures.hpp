// SPDX-License-Identifier: MIT
#pragma once
/// Pictures of a run with a needle or a probe: force over depth and time, its parts, pressure.

#include <vector>

#include "model/dynamics/trace.hpp"
#include "validation/outcome.hpp"

namespace palpate {

/// In the order of a page; empty without a tool, or with fewer than two ticks.
std::vector<Figure> tool_figures(const Trace& trace);

/// Force with its parts, and pressure, over time: to zoom into.
std::vector<Figure> tool_traces(const Trace& trace);

}  // namespace palpate
