// SPDX-License-Identifier: MIT
#pragma once
/// Time series of a run: a simulator, a reference solution, a baseline or a recording.

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/problem/spring_network.hpp"

namespace palpate {

/// Largest number of values of a trace, written or read: 800 MB in memory, 8 hours at 1 kHz of a
/// scene with a needle.
inline constexpr std::size_t most_trace_values = 100'000'000;

struct Column {
  std::string name{};            ///< as in trace.csv, e.g. "tip.x_m"
  std::string unit{};            ///< e.g. "m"
  std::vector<double> values{};  ///< one per row
};

struct TextColumn {
  std::string name{};
  std::vector<std::string> values{};
};

struct Event {
  double time = 0.0;  ///< [s]
  std::string kind{};
  std::string detail{};
};

/// Positions of all nodes of a network at selected times, in order of time.
struct Frames {
  std::vector<double> time{};           ///< [s]
  std::vector<NodeVectors> position{};  ///< in the scene's node numbering [m]
};

/// Kinetic, elastic and potential energy over a run [J].
struct EnergyRange {
  double initial = 0.0;
  double final = 0.0;
  double maximum = 0.0;
};

struct Trace {
  std::vector<double> time{};  ///< [s], one per row
  std::vector<Column> columns{};
  std::vector<TextColumn> text_columns{};
  std::vector<Event> events{};
  /// Coordinates of the problem (three for each free node, in node order), dof x rows [m, m/s];
  /// empty if not sampled.
  Eigen::MatrixXd position{};
  Eigen::MatrixXd velocity{};
  Frames frames{};  ///< evenly spaced in time
  /// Smallest corner Jacobian of all cells and its time [1, s]; 1 if the cells were not checked.
  double smallest_jacobian = 1.0;
  double smallest_jacobian_at = 0.0;
  long inverted_cells = 0;  ///< largest number of cells inside out at one time
  Frames keyframes{};       ///< at events and at the largest force on the tool

  std::string method{};             ///< integrator of a run, or solver of a reference
  std::string version{};            ///< of a reference solver, e.g. "SUNDIALS 6.4.1"
  double relative_tolerance = 0.0;  ///< of a reference solver
  double h = 0.0;                   ///< step of the integrator [s]
  int substeps = 1;                 ///< integrator steps per tick

  bool diverged = false;     ///< rows end before the first state not finite or out of bounds
  double diverged_at = 0.0;  ///< [s]
  bool interrupted = false;

  long ticks = 0;             ///< including the tick that diverged
  long steps = 0;             ///< of the integrator
  long evaluations = 0;       ///< of the right-hand side, if counted
  double seconds = 0.0;       ///< wall time without sampling and waiting [s]
  double slowest_tick = 0.0;  ///< [s]
  EnergyRange energy{};       ///< over all ticks, if sampled

  [[nodiscard]] std::size_t rows() const { return time.size(); }
  /// Returns the column of that name, or nullptr.
  [[nodiscard]] const Column* find(std::string_view name) const {
    const auto found = std::ranges::find(columns, name, &Column::name);
    return found == columns.end() ? nullptr : &*found;
  }
  /// Returns the values of a column. Throws std::out_of_range if there is no such column.
  [[nodiscard]] const std::vector<double>& values(std::string_view name) const {
    const Column* column = find(name);
    if (column == nullptr) { throw std::out_of_range("no column " + std::string(name)); }
    return column->values;
  }
  [[nodiscard]] std::vector<double>& values(std::string_view name) {
    return const_cast<std::vector<double>&>(std::as_const(*this).values(name));
  }
  [[nodiscard]] double at(std::string_view name, std::size_t row) const {
    return values(name)[row];
  }
  /// Returns the values of a text column. Throws std::out_of_range if there is no such column.
  [[nodiscard]] const std::vector<std::string>& texts(std::string_view name) const {
    const auto found = std::ranges::find(text_columns, name, &TextColumn::name);
    if (found == text_columns.end()) { throw std::out_of_range("no column " + std::string(name)); }
    return found->values;
  }
  /// Returns the time of the first such event [s], with any detail if it is empty; NaN if none.
  [[nodiscard]] double time_of(std::string_view kind, std::string_view detail = {}) const {
    const auto found = std::ranges::find_if(events, [&](const Event& event) {
      return event.kind == kind && (detail.empty() || event.detail == detail);
    });
    return found == events.end() ? std::numeric_limits<double>::quiet_NaN() : found->time;
  }
  [[nodiscard]] long count(std::string_view kind) const {
    return std::ranges::count(events, kind, &Event::kind);
  }
};

}  // namespace palpate
