// SPDX-License-Identifier: MIT
#pragma once
/// A loop with absolute deadlines: woken at every release, it works and sleeps until the next one. It
/// allocates nothing and calls the system for nothing but the clock and its sleep.

#include <atomic>
#include <utility>

#include "device/deadline_clock.hpp"
#include "device/real_time.hpp"
#include "validation/certificate/loop_record.hpp"

namespace palpate::certificate {

/// A loop that is so late will not catch up while anybody waits [s].
inline constexpr double hopeless_lateness = 2.0;

enum class LoopEnd {
  done,      ///< as many ticks as were asked for
  over,      ///< the work said that nothing is left of it
  stopped,   ///< Ctrl-C
  hopeless,  ///< later than hopeless_lateness
};

struct PacedLoop {
  double period = 1e-3;                     ///< [s]
  const std::atomic<bool>* stop = nullptr;  ///< looked at between ticks
  std::atomic<long>* done = nullptr;        ///< ticks so far, for whoever shows progress
  device::ThreadCounts counts{};            ///< of what the system did to the thread in its ticks

  /// `work(moment)` is one tick, tells where in the scene it was, and is false where it was the last one.
  template <class Work>
  LoopEnd run(long ticks, LoopRecord& record, Work&& work) noexcept {
    (void)device::monotonic_now();  // the page that the clock is read from comes with the first look
    const device::ThreadCounts before = device::thread_counts();
    device::DeadlineClock clock(period);
    LoopEnd end = LoopEnd::done;
    for (long n = 0; n < ticks && end == LoopEnd::done; ++n) {
      TickTimes times;
      Moment moment;
      times.due = clock.wait();
      times.begin = device::monotonic_now();
      const bool more = work(moment);
      times.end = device::monotonic_now();
      record.add(times, moment);
      if (done != nullptr) { done->fetch_add(1, std::memory_order_relaxed); }
      end = !more                                                      ? LoopEnd::over
            : times.end - times.due > hopeless_lateness                ? LoopEnd::hopeless
            : stop != nullptr && stop->load(std::memory_order_relaxed) ? LoopEnd::stopped
                                                                       : LoopEnd::done;
    }
    counts += device::thread_counts() - before;
    return end;
  }
};

}  // namespace palpate::certificate
