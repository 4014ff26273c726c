// SPDX-License-Identifier: MIT
#include "validation/certificate/timed_passes.hpp"

#include <algorithm>
#include <cmath>

#include "validation/bench/interleaved.hpp"

namespace palpate::certificate {

namespace {

using bench::Clock;
using bench::seconds_on;

bool is_stopped(const ProvocationPlan& plan) {
  return plan.stop != nullptr && plan.stop->load(std::memory_order_relaxed);
}

TimedTick time_tick(SceneLoop& loop, StepStatus& status) {
  const double wall = seconds_on(Clock::wall);
  const double processor = seconds_on(Clock::processor);
  status = loop.tick();
  const double processor_after = seconds_on(Clock::processor);
  return {.processor = processor_after - processor, .wall = seconds_on(Clock::wall) - wall};
}

/// One pass from the start; fewer ticks than it should have where it was stopped or diverged.
TimedPasses one_pass(const PassSetting& setting, const ProvocationPlan& plan) {
  const std::unique_ptr<SceneLoop> loop = setting.make();
  TimedPasses pass;
  auto count = static_cast<std::size_t>(loop->tick_count());
  if (setting.most_ticks > 0) { count = std::min(count, setting.most_ticks); }
  pass.ticks.reserve(count);
  while (pass.ticks.size() < count && !is_stopped(plan)) {
    if (setting.before) { setting.before(pass.ticks.size()); }
    StepStatus status = StepStatus::ok;
    pass.ticks.push_back(time_tick(*loop, status));
    if (status == StepStatus::diverged) {
      pass.diverged_at = loop->simulation().time();
      return pass;
    }
    for (const ToolHappening& each : loop->happenings()) {
      pass.happenings.push_back({pass.ticks.size() - 1, each});
    }
    pass.largest_speed = std::max(pass.largest_speed, std::abs(loop->simulation().tool_motion().velocity));
  }
  pass.passes = pass.ticks.size() == count ? 1 : 0;
  return pass;
}

/// Of what a tick takes, by which it may still fall from one pass to the next when it is taken as its cost:
/// on a virtual machine the thread's clock goes on while the hypervisor has the processor.
constexpr double same = 0.95;

void keep_least(TimedPasses& least, TimedPasses pass) {
  if (least.passes == 0) {
    least = std::move(pass);
    return;
  }
  ++least.passes;
  for (std::size_t k = 0; k < least.ticks.size(); ++k) {
    least.ticks[k].processor = std::min(least.ticks[k].processor, pass.ticks[k].processor);
    least.ticks[k].wall = std::min(least.ticks[k].wall, pass.ticks[k].wall);
  }
}

}  // namespace

double TimedPasses::worst() const { return ticks[costliest(0, ticks.size())].processor; }

std::size_t TimedPasses::costliest(std::size_t begin, std::size_t end) const {
  const auto first = ticks.begin();
  const auto worst =
      std::ranges::max_element(first + static_cast<std::ptrdiff_t>(begin),
                               first + static_cast<std::ptrdiff_t>(end), {}, &TimedTick::processor);
  return static_cast<std::size_t>(worst - first);
}

std::size_t TimedPasses::costliest(const std::vector<std::size_t>& of) const {
  return *std::ranges::max_element(of, {}, [this](std::size_t n) { return ticks[n].processor; });
}

TimedPasses time_passes(const PassSetting& setting, const ProvocationPlan& plan) {
  const double begin = seconds_on(Clock::wall);
  TimedPasses least;
  bool settled = false;
  for (int n = 0; n < plan.most_repetitions; ++n) {
    if (settled && n >= plan.least_repetitions && seconds_on(Clock::wall) - begin > plan.enough) { break; }
    TimedPasses pass = one_pass(setting, plan);
    if (pass.diverged_at) { return pass; }
    if (pass.passes == 0) { break; }
    const double before = least.passes > 0 ? least.worst() : 0.0;
    keep_least(least, std::move(pass));
    settled = least.worst() >= same * before;
  }
  return least;
}

}  // namespace palpate::certificate
