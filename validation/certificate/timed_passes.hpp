// SPDX-License-Identifier: MIT
#pragma once
/// A scene's ticks, timed one by one over several passes from its start.

#include <functional>
#include <memory>
#include <vector>

#include "validation/certificate/provocation.hpp"
#include "validation/certificate/scene_loop.hpp"

namespace palpate::certificate {

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

/// As many passes as the plan asks for, and more until the costliest tick falls no further. None is kept of a pass
/// that was stopped.
TimedPasses time_passes(const PassSetting& setting, const ProvocationPlan& plan);

}  // namespace palpate::certificate
