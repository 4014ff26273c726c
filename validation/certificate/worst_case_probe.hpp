// SPDX-License-Identifier: MIT
#pragma once
/// What one missed tick does to the hand: the force of the tick before is held for one more period.

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/problem/scene.hpp"
#include "validation/certificate/scene_loop.hpp"

namespace palpate::certificate {

struct MissedTick {
  double stiffness = 0.0;      ///< K at the hand [N/m]
  double speed = 0.0;          ///< v, the largest of grip and tool [m/s]
  double bound = 0.0;          ///< 1/2 K (v T)^2: against a spring that is never held [J]
  double sampled_bound = 0.0;  ///< K (v T)^2: against the same loop with the tick kept [J]
  /// Through an emulated Falcon: what the worst single tick gave the hand more than if it had been
  /// kept [J].
  std::optional<double> measured{};
  double measured_at = 0.0;  ///< [s]
};

/// While the force of a spring K is held, it grows wrong by K v t and the hand moves on with v: 1/2
/// K (v T)^2 of work over a period. A loop that keeps its ticks holds forces too, so that beside it
/// a missed tick is wrong by the whole K v T from its first instant: twice as much.
MissedTick bounded_missed_tick(double stiffness, double speed, double period);

/// Of a scene whose drive is the Falcon: K is the coupling's. The passivity observer sits at the
/// grip; the tick where the change of force times the way of the grip is largest is missed in a
/// second run.
MissedTick measure_missed_tick(const Scene& scene, const std::atomic<bool>* stop);

// The worst ticks of a scene, provoked instead of awaited: what each costs by itself. The same tick
// is the same work every time, so that the least over several repetitions is its cost, however busy
// the machine is.

struct Provocation {
  std::string name{};       ///< "puncture: ligamentum flavum"
  std::string what{};       ///< how it was provoked
  double scene_time = 0.0;  ///< of the tick that took longest [s]
  double processor = 0.0;  ///< its time on the thread's own clock, the least of the repetitions [s]
  double wall = 0.0;       ///< by the wall clock, the least likewise [s]
  int repetitions = 0;
  long ticks = 0;  ///< that were tried
};

/// What a tick may cost, and what the costliest one does.
struct ComputeBudget {
  std::vector<Provocation> provocations{};  ///< costliest first
  /// Instructions of the costliest tick, where somebody counted them.
  std::optional<std::int64_t> worst_instructions{};
  double largest_speed = 0.0;           ///< of the tool [m/s]
  std::optional<double> diverged_at{};  ///< [s]; then there is nothing else to say
  long skipped_events = 0;              ///< of the scene, that were not reached

  [[nodiscard]] double worst() const {
    return provocations.empty() ? 0.0 : provocations.front().processor;
  }
};

struct ProvocationPlan {
  double rate = 1000.0;                  ///< [Hz]
  std::size_t cache_bytes = 32U << 20U;  ///< of the largest cache
  int least_repetitions = 3;
  int most_repetitions = 12;
  double enough = 1.0;  ///< [s] after which no repetition is added
  const std::atomic<bool>* stop = nullptr;
  std::function<void(const std::string& stage)> tell{};
};

/// The scene from beginning to end as fast as it goes, and special ticks of it.
ComputeBudget provoke(const Scene& scene, const ProvocationPlan& plan);

// A scene's ticks, timed one by one over several passes from its start.

struct TimedTick {
  double processor = 0.0;  ///< least over the passes [s]
  double wall = 0.0;       ///< likewise
};

struct Happened {
  std::size_t tick = 0;
  ToolHappening happening{};
};

struct TimedPasses {
  std::vector<TimedTick> ticks{};
  std::vector<Happened> happenings{};
  double largest_speed = 0.0;  ///< of the tool [m/s]
  int passes = 0;              ///< that were finished
  std::optional<double> diverged_at{};

  /// The tick that costs most of those in [begin, end), and of a list.
  [[nodiscard]] std::size_t costliest(std::size_t begin, std::size_t end) const;
  [[nodiscard]] std::size_t costliest(const std::vector<std::size_t>& of) const;
  [[nodiscard]] double worst() const;  ///< of all ticks [s]
};

struct PassSetting {
  std::function<std::unique_ptr<SceneLoop>()> make{};
  std::size_t most_ticks = 0;                      ///< 0: the whole scene
  std::function<void(std::size_t tick)> before{};  ///< outside the time of the tick; empty: nothing
};

/// As many passes as the plan asks for, and more until the costliest tick falls no further. None is
/// kept of a pass that was stopped.
TimedPasses time_passes(const PassSetting& setting, const ProvocationPlan& plan);

}  // namespace palpate::certificate
