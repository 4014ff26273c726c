// SPDX-License-Identifier: MIT
#pragma once
/// The trace of a tool as people look at it: where it was deeper than ever before, which layer it
/// was in, and what happened where.

#include <optional>
#include <string>
#include <vector>

#include "model/dynamics/trace.hpp"
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

}  // namespace palpate
