// SPDX-License-Identifier: MIT
#pragma once
/// The worst ticks of a scene, provoked instead of awaited: what each costs by itself. The same tick is the
/// same work every time, so that the least over several repetitions is its cost, however busy the machine is.

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "model/dynamics/scene.hpp"

namespace palpate::certificate {

struct Provocation {
  std::string name{};       ///< "puncture: ligamentum flavum"
  std::string what{};       ///< how it was provoked
  double scene_time = 0.0;  ///< of the tick that took longest [s]
  double processor = 0.0;   ///< its time on the thread's own clock, the least of the repetitions [s]
  double wall = 0.0;        ///< by the wall clock, the least likewise [s]
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

  [[nodiscard]] double worst() const { return provocations.empty() ? 0.0 : provocations.front().processor; }
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

}  // namespace palpate::certificate
