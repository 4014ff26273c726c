// SPDX-License-Identifier: MIT
#pragma once
/// Evaluation of tool traces for display: first pass over depth, layers and events.

#include <optional>
#include <string>
#include <vector>

#include "model/problem/trace.hpp"
#include "reports/html/html_page.hpp"
#include "validation/outcome.hpp"

namespace palpate {

/// Returns true if the trace has columns of a needle or a probe.
bool has_tool(const Trace& trace);
/// Returns the values of a column. Throws std::out_of_range if the trace has no such column.
const std::vector<double>& values_of(const Trace& trace, const std::string& name);

/// Horizontal axis of a figure: time [s], or depth of the tip [mm].
enum class Over { time, depth };

/// Figure without series, with the layers and the events of the trace.
Figure figure_over(const Trace& trace, Over over, const std::string& id, const std::string& title,
                   const std::string& caption, const std::string& y_label);

/// Adds a column, multiplied by `factor`. Does nothing if the trace has no such column.
void add_column(Figure& figure, const Trace& trace, Over over, const std::string& column,
                const std::string& label = "", double factor = 1.0,
                Series::Style style = Series::Style::line);

/// Row indices in which the tip is deeper than in all earlier rows. The first is the last row at
/// the initial depth.
std::vector<std::size_t> first_pass(const Trace& trace);

/// Layers of the first pass over the tip depth [mm].
std::vector<Zone> layers_over_depth(const Trace& trace);
/// Layers over time [s].
std::vector<Zone> layers_over_time(const Trace& trace);

/// Index of the first row at or after a time [s]; the last row if there is none.
std::size_t row_at(const Trace& trace, double time);

/// Label of the layer that contains the tip in a row; empty outside the tissue.
std::string layer_in(const Trace& trace, std::size_t row);

/// Kind of an event as text: "loss of resistance" for "loss-of-resistance".
std::string in_words(std::string kind);

/// Largest depth, peak force with its position, loss of resistance, peak pressure; empty without a
/// tool.
std::vector<Fact> tool_facts(const Trace& trace);

/// Table of events in order of time. With a tool it includes the depth and the force one tick
/// before and at the event.
Table events_table(const Trace& trace);

/// Figures in page order; empty without a tool or with fewer than two ticks.
std::vector<Figure> tool_figures(const Trace& trace);

/// Figures of force with its components and of pressure over time, for interactive plots.
std::vector<Figure> tool_traces(const Trace& trace);

/// One figure per record and unit ("tip.x_m", "tip.y_m", "tip.z_m"). Positions are drawn as
/// displacements from the first tick, since motion is small relative to position. Tool columns are
/// excluded; see tool_figures().
std::vector<Figure> figures_over_time(const Trace& trace);

/// Displacement scale factor for a picture of `extent` [m] and displacements up to `distance` [m]:
/// 1, 2 or 5 times a power of ten, at least 1.
double enlargement(double distance, double extent);

}  // namespace palpate
