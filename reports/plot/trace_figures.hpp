// SPDX-License-Identifier: MIT
#pragma once
/// The trace of a tool as people look at it: where it was deeper than ever before, which layer it
/// was in, and what happened where.

#include <optional>
#include <string>
#include <vector>

#include "model/problem/trace.hpp"
#include "reports/html/html_page.hpp"
#include "validation/outcome.hpp"

namespace palpate {

/// Whether the scene had a needle or a probe.
bool has_tool(const Trace& trace);
/// Columns that belong to the tool or its syringe, shown in pictures of their own.
bool is_tool_column(const std::string& name);

/// Values of a column; throws std::out_of_range where the trace has none of that name.
const std::vector<double>& values_of(const Trace& trace, const std::string& name);

/// The same, each times a factor.
std::vector<double> values_of(const Trace& trace, const std::string& name, double factor);

/// Rows in which the tip is deeper than in any row before, beginning with the last row in which it
/// lay at its first depth.
std::vector<std::size_t> first_pass(const Trace& trace);

/// Layers on the first pass over the tip's depth [mm].
std::vector<Zone> layers_over_depth(const Trace& trace);
/// Layers over time [s].
std::vector<Zone> layers_over_time(const Trace& trace);

/// First row at or after a time; the last row for what comes later.
std::size_t row_at(const Trace& trace, double time);

/// Events at the depth [mm] that the tip had, and at their time [s].
std::vector<Mark> events_over_depth(const Trace& trace);
std::vector<Mark> events_over_time(const Trace& trace);

/// Label of the layer in a row; empty outside the tissue.
std::string layer_in(const Trace& trace, std::size_t row);

/// "loss of resistance" of "loss-of-resistance".
std::string in_words(std::string kind);

// What people ask first about a run with a tool, and what happened in it.

/// Deepest place, peak force and where, loss of resistance, peak pressure; empty without a tool.
std::vector<Fact> tool_facts(const Trace& trace);

/// Events in order of time; with a tool also its depth, and the force one tick before and at the
/// event.
Table events_table(const Trace& trace);

// Pictures of a run with a needle or a probe: force over depth and time, its parts, pressure.

/// In the order of a page; empty without a tool, or with fewer than two ticks.
std::vector<Figure> tool_figures(const Trace& trace);

/// Force with its parts, and pressure, over time: to zoom into.
std::vector<Figure> tool_traces(const Trace& trace);

// The figures of a run: its columns over time, and where its nodes were.

/// One figure for each record and unit ("tip.x_m", "tip.y_m", "tip.z_m"). Positions are drawn as
/// displacements from the first tick, as what moves is far smaller than where it is. What belongs
/// to a tool is in tool_figures.hpp.
std::vector<Figure> figures_over_time(const Trace& trace);

/// 1, 2 or 5 times a power of ten by which displacements up to `distance` are enlarged to be seen
/// in a picture of `extent` [m]; at least 1.
double enlargement(double distance, double extent);

/// Nodes of the slice in which a node has moved furthest, at rest and then. Nothing when no frame
/// differs from the first.
std::optional<Figure> snapshot_figure(const Trace& trace);

}  // namespace palpate
