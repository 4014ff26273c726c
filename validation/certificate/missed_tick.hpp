// SPDX-License-Identifier: MIT
#pragma once
/// What one missed tick does to the hand: the force of the tick before is held for one more period.

#include <atomic>
#include <optional>

#include "model/dynamics/scene.hpp"

namespace palpate::certificate {

struct MissedTick {
  double stiffness = 0.0;      ///< K at the hand [N/m]
  double speed = 0.0;          ///< v, the largest of grip and tool [m/s]
  double bound = 0.0;          ///< 1/2 K (v T)^2: against a spring that is never held [J]
  double sampled_bound = 0.0;  ///< K (v T)^2: against the same loop with the tick kept [J]
  /// Through an emulated Falcon: what the worst single tick gave the hand more than if it had been kept [J].
  std::optional<double> measured{};
  double measured_at = 0.0;  ///< [s]
};

/// While the force of a spring K is held, it grows wrong by K v t and the hand moves on with v: 1/2 K (v T)^2
/// of work over a period. A loop that keeps its ticks holds forces too, so that beside it a missed tick is
/// wrong by the whole K v T from its first instant: twice as much.
MissedTick bounded_missed_tick(double stiffness, double speed, double period);

/// Of a scene whose drive is the Falcon: K is the coupling's. The passivity observer sits at the grip; the
/// tick where the change of force times the way of the grip is largest is missed in a second run.
MissedTick measure_missed_tick(const Scene& scene, const std::atomic<bool>* stop);

}  // namespace palpate::certificate
