// SPDX-License-Identifier: MIT
#pragma once
/// The one loop of a whole run: Simulation -> Trace, with what a person asks about it afterwards.

#include <atomic>
#include <functional>
#include <optional>

#include "model/dynamics/trace.hpp"
#include "model/stepping/simulation.hpp"
#include "validation/falcon_loop.hpp"
#include "validation/moments.hpp"

namespace palpate {

struct RunEnergy {
  double initial = 0.0;  ///< [J]
  double final = 0.0;    ///< [J]
  double maximum = 0.0;  ///< over the ticks [J]
};

struct Run {
  Trace trace{};
  Moments moments{};              ///< beside the frames of the trace
  bool diverged = false;
  double diverged_at = 0.0;       ///< [s]
  bool interrupted = false;
  long ticks = 0;
  long steps = 0;                 ///< of the integrator
  double seconds = 0.0;           ///< wall time of the ticks alone
  double slowest_tick = 0.0;      ///< [s]
  RunEnergy energy{};
  int zero_length_springs = 0;    ///< at the end
  std::optional<FalconFacts> falcon{};  ///< of a tool in a hand
  std::optional<device::DeadlineFacts> real_time{};  ///< where ticks waited for the wall clock

  [[nodiscard]] double ns_per_spring_step(std::size_t springs) const {
    return steps == 0 || springs == 0
               ? 0.0
               : 1e9 * seconds / (static_cast<double>(steps) * static_cast<double>(springs));
  }
};

struct RollOutOptions {
  int frames = 0;                             ///< snapshots of all nodes, evenly over the ticks
  int events = 0;                             ///< snapshots at the first so many ticks with events, and at the
                                              ///< tool's largest force
  const std::atomic<bool>* stop = nullptr;    ///< looked at between ticks
  std::function<void(double share)> progress{};  ///< 0 to 1, a few times a second at most
  std::function<bool(const Trace&)> enough{};  ///< after every tick: true ends the run, as its duration would
  device::DeadlineClock* clock = nullptr;     ///< that every tick waits for; as fast as it goes without
  FalconLoop* falcon = nullptr;               ///< of a scene whose tool a hand holds
};

/// Runs to the scene's duration, to divergence, or to a stop. The trace keeps every tick before
/// the first state that was not finite or out of bounds.
Run roll_out(Simulation& simulation, const RollOutOptions& options);

}  // namespace palpate
