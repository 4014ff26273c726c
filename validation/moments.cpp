// SPDX-License-Identifier: MIT
#include "validation/moments.hpp"

#include <algorithm>
#include <cmath>

namespace palpate {

MomentKeeper::MomentKeeper(const Simulation& simulation, int most) {
  const auto& columns = simulation.columns();
  const auto force = std::ranges::find(columns, "tool.force_n", &Column::name);
  if (force == columns.end() || most <= 0) { return; }
  force_column_ = static_cast<std::size_t>(force - columns.begin());
  at_largest_ = simulation.node_positions();
  at_events_.time.resize(static_cast<std::size_t>(most));
  at_events_.positions.assign(at_events_.time.size(), at_largest_);
}

void MomentKeeper::take(Simulation& simulation, const Trace& trace) noexcept {
  if (at_events_.time.empty()) { return; }
  const double force = trace.columns[force_column_].values.back();
  if (std::isfinite(force) && force > largest_) {
    largest_ = force;
    largest_time_ = simulation.time();
    simulation.node_positions(at_largest_);
  }
  if (trace.events.size() > events_seen_ && kept_ < at_events_.time.size()) {
    at_events_.time[kept_] = simulation.time();
    simulation.node_positions(at_events_.positions[kept_]);
    ++kept_;
  }
  events_seen_ = trace.events.size();
}

Moments MomentKeeper::moments() {
  at_events_.time.resize(kept_);
  at_events_.positions.resize(kept_);
  if (largest_ > 0.0) {
    const auto after = std::ranges::lower_bound(at_events_.time, largest_time_);
    const auto place = after - at_events_.time.begin();
    if (after == at_events_.time.end() || *after != largest_time_) {
      at_events_.time.insert(after, largest_time_);
      at_events_.positions.insert(at_events_.positions.begin() + place, std::move(at_largest_));
    }
  }
  return std::move(at_events_);
}

}  // namespace palpate
