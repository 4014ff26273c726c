// SPDX-License-Identifier: MIT
#pragma once
/// The figures of a run: its columns over time, and where its nodes were.

#include <optional>
#include <vector>

#include "model/dynamics/trace.hpp"
#include "validation/outcome.hpp"

namespace palpate {

/// One figure for each record and unit ("tip.x_m", "tip.y_m", "tip.z_m"). Positions are drawn as
/// displacements from the first tick, as what moves is far smaller than where it is. What belongs to
/// a tool is in tool_figures.hpp.
std::vector<Figure> figures_over_time(const Trace& trace);

/// 1, 2 or 5 times a power of ten by which displacements up to `distance` are enlarged to be seen in a
/// picture of `extent` [m]; at least 1.
double enlargement(double distance, double extent);

/// Nodes of the slice in which a node has moved furthest, at rest and then. Nothing when no frame
/// differs from the first.
std::optional<Figure> snapshot_figure(const Trace& trace);

}  // namespace palpate
