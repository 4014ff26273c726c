// SPDX-License-Identifier: MIT
#pragma once
/// Where all nodes were when something happened: at ticks with events, and when the tool felt most.

#include <vector>

#include "model/dynamics/trace.hpp"
#include "model/stepping/simulation.hpp"

namespace palpate {

/// Snapshots of all nodes in order of time.
struct Moments {
  std::vector<double> time{};            ///< [s]
  std::vector<NodeVectors> positions{};  ///< [m]
};

/// Keeps them while a run goes on. Everything is allocated on construction, take() allocates nothing.
class MomentKeeper {
 public:
  /// The first `most` ticks with events, and one of largest force; a run without a tool has neither.
  MomentKeeper(const Simulation& simulation, int most);
  /// After each tick; `trace` holds its row and its events.
  void take(Simulation& simulation, const Trace& trace) noexcept;
  /// What was kept; once, when the run is over.
  [[nodiscard]] Moments moments();

 private:
  std::size_t force_column_ = 0;
  std::size_t kept_ = 0;
  std::size_t events_seen_ = 0;
  double largest_ = 0.0;       ///< force so far [N]
  double largest_time_ = 0.0;  ///< [s]
  Moments at_events_;
  NodeVectors at_largest_;
};

}  // namespace palpate
