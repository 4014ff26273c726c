// SPDX-License-Identifier: MIT
#pragma once
/// Energy effect of one missed tick on the hand: the force of the previous tick is applied for one
/// more period.

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
  double speed = 0.0;          ///< v, largest speed of grip and tool
  double bound = 0.0;          ///< 1/2 K (v T)^2: relative to a continuous spring
  double sampled_bound = 0.0;  ///< K (v T)^2: relative to the same loop without a missed tick
  /// Energy that the worst single missed tick gives the hand in excess of the run without a missed
  /// tick, through an emulated Falcon [J].
  std::optional<double> measured{};
  double measured_at = 0.0;  ///< [s]
};

/// Returns the bounds for a spring K [N/m] and a hand speed v [m/s]. While the force is held, its
/// error grows as K v t, which does the work 1/2 K (v T)^2 over a period. A loop without missed
/// ticks also holds its forces; relative to it the force error is K v T from the first instant, so
/// the work is twice as large.
MissedTick bounded_missed_tick(double stiffness, double speed, double period);

/// Measures the effect of a missed tick in a scene driven by the Falcon; K is the stiffness of the
/// coupling. The passivity observer is at the grip. A second run misses the tick with the largest
/// product of force change and grip displacement.
MissedTick measure_missed_tick(const Scene& scene, const std::atomic<bool>* stop);

// Worst-case probes: they trigger the most expensive ticks of a scene and measure the cost of each.
// The same tick does the same work every time, so the minimum over several repetitions is its cost,
// independent of other load on the machine.

struct WorstCaseProbe {
  std::string name{};       ///< "puncture: ligamentum flavum"
  std::string what{};       ///< how it was triggered
  double scene_time = 0.0;  ///< time of the longest tick in the scene
  double processor = 0.0;   ///< thread processor time, minimum over the repetitions
  double wall = 0.0;        ///< wall time, minimum over the repetitions
  int repetitions = 0;
  long ticks = 0;  ///< ticks measured
};

/// Event of the tool and the tick of the scene in which it occurs.
struct Happened {
  std::size_t tick = 0;
  ToolHappening happening{};
};

/// Computation times of the worst-case probes and limits of their coverage.
struct ComputeBudget {
  std::vector<WorstCaseProbe> probes{};  ///< slowest first
  std::vector<Happened> happenings{};    ///< of the whole scene; each has a probe
  std::vector<std::string> absent{};     ///< declared events that the whole scene does not reach
  /// Instructions of the slowest tick; absent if they were not counted.
  std::optional<std::int64_t> worst_instructions{};
  double largest_speed = 0.0;           ///< of the tool [m/s]
  std::optional<double> diverged_at{};  ///< [s]; the other members are then not set

  [[nodiscard]] double worst() const { return probes.empty() ? 0.0 : probes.front().processor; }
};

struct ProbePlan {
  double rate = 1000.0;                  ///< [Hz]
  std::size_t cache_bytes = 32U << 20U;  ///< size of the largest cache [bytes]
  int least_repetitions = 3;
  int most_repetitions = 12;
  double enough = 1.0;  ///< time after which no repetition is started [s]
  const std::atomic<bool>* stop = nullptr;
  std::function<std::unique_ptr<Subject>()> subject{};  ///< empty: the model
};

/// Returns the events that the scene declares and that are not among those of its whole run:
/// contact of a tool, the end of an advance to a given depth, the end of a withdrawal.
std::vector<std::string> absent_events(const Scene& scene, const std::vector<Happened>& happenings);

/// Runs the whole scene as fast as possible and then the worst-case probes at selected ticks.
ComputeBudget run_probes(const Scene& scene, const ProbePlan& plan);

// Times of individual ticks over several passes of a scene.

struct TimedTick {
  double processor = 0.0;  ///< minimum over the passes [s]
  double wall = 0.0;       ///< likewise
};

struct TimedPasses {
  std::vector<TimedTick> ticks{};
  std::vector<Happened> happenings{};
  double largest_speed = 0.0;  ///< of the tool [m/s]
  int passes = 0;              ///< passes completed
  std::optional<double> diverged_at{};

  /// Returns the slowest tick of all, or of a list.
  [[nodiscard]] std::size_t costliest() const;
  [[nodiscard]] std::size_t costliest(const std::vector<std::size_t>& of) const;
  [[nodiscard]] double worst() const;  ///< time of the slowest tick [s]
};

struct PassSetting {
  std::function<std::unique_ptr<SceneLoop>()> make{};
  std::size_t most_ticks = 0;                      ///< 0: the whole scene
  std::function<void(std::size_t tick)> before{};  ///< called outside the time of each tick
};

/// Times as many passes as the plan requests, and more until the time of the slowest tick no longer
/// decreases. A pass that was stopped is discarded.
TimedPasses time_passes(const PassSetting& setting, const ProbePlan& plan);

}  // namespace palpate::certificate
