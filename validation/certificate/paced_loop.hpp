// SPDX-License-Identifier: MIT
#pragma once
/// Histogram of times in bins of 1 us, so that memory does not grow with the duration. No
/// allocation after construction.

#include <atomic>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "device/real_time.hpp"
#include "model/stepping/tool_report.hpp"

namespace palpate::certificate {

class LatencyHistogram {
 public:
  static constexpr double bin_width = 1e-6;  ///< [s]
  static constexpr std::size_t bin_count =
      100000;  ///< the last bin contains all times from 0.1 s on

  LatencyHistogram() : counts_(bin_count, 0) {}

  void add(double seconds) noexcept;

  [[nodiscard]] long count() const { return count_; }
  [[nodiscard]] double minimum() const { return minimum_; }  ///< [s]; 0 if empty
  [[nodiscard]] double maximum() const { return maximum_; }  ///< [s]; 0 if empty
  [[nodiscard]] std::span<const std::uint32_t> counts() const { return counts_; }
  /// Returns the number of bins up to the last one that is not empty.
  [[nodiscard]] std::size_t used_bins() const;
  /// Returns the time [s] that this share of all samples does not exceed: the upper edge of the bin
  /// of the ordered sample at ceil(share n), up to 1 us too long and never too short. Beyond the
  /// bins it is the maximum. Absent if no sample lies above it, that is, for fewer than 1 / (1 -
  /// share) samples.
  [[nodiscard]] std::optional<double> percentile(double share) const;

 private:
  std::vector<std::uint32_t> counts_;
  long count_ = 0;
  double minimum_ = 0.0;
  double maximum_ = 0.0;
};

// Record of a loop with deadlines: times of every tick and its misses. Times are measured from the
// scheduled release, never from the actual start, so a late tick also delays the following ticks.

/// Position of a tick in the scene.
struct Moment {
  double scene_time = 0.0;                   ///< [s]
  std::optional<ToolHappening> happening{};  ///< last event in this tick
};

/// Instants of one tick [s].
struct TickTimes {
  double due = 0.0;    ///< scheduled release
  double begin = 0.0;  ///< actual start
  double end = 0.0;    ///< end of its work
};

/// Largest time of one kind and the tick in which it occurred.
struct Peak {
  double seconds = -1.0;  ///< below 0: none yet
  long tick = 0;
  Moment moment{};
};

/// Statistics of ticks whose response time exceeded the deadline.
class Misses {
 public:
  void add(bool missed, const TickTimes& times) noexcept;
  [[nodiscard]] long count() const { return count_; }
  [[nodiscard]] long longest_run() const { return longest_run_; }
  /// Returns the longest time from the release of a first missed tick to the next tick that met its
  /// deadline [s].
  [[nodiscard]] double longest_recovery() const { return longest_recovery_; }

 private:
  long count_ = 0;
  long run_ = 0;
  long longest_run_ = 0;
  double run_began_ = 0.0;
  double longest_recovery_ = 0.0;
};

struct LargeTick {
  double seconds = 0.0;
  long tick = 0;
};

/// Set of the `capacity` largest times so far; no allocation after construction.
class LargestTicks {
 public:
  explicit LargestTicks(std::size_t capacity);
  void add(const LargeTick& tick) noexcept;
  [[nodiscard]] std::vector<LargeTick> sorted() const;  ///< largest first

 private:
  std::size_t capacity_;
  std::vector<LargeTick> heap_{};  ///< min-heap
};

/// Number of response times stored for the tail.
inline constexpr std::size_t kept_responses = 4001;

class LoopRecord {
 public:
  explicit LoopRecord(double deadline) : deadline_(deadline) {}
  void add(const TickTimes& times, const Moment& moment) noexcept;

  [[nodiscard]] long ticks() const { return wakeup.count(); }

  LatencyHistogram wakeup{};    ///< begin - due
  LatencyHistogram compute{};   ///< end - begin
  LatencyHistogram response{};  ///< end - due
  Peak worst_wakeup{};
  Peak worst_compute{};
  Peak worst_response{};
  Misses misses{};
  LargestTicks largest{kept_responses};  ///< responses

 private:
  double deadline_;
};

/// A loop later than this is aborted [s].
inline constexpr double hopeless_lateness = 2.0;

enum class LoopEnd {
  done,      ///< all requested ticks done
  over,      ///< the work function returned false
  stopped,   ///< Ctrl-C
  hopeless,  ///< later than hopeless_lateness
};

/// Loop with absolute deadlines: it wakes at every release, works, and sleeps until the next
/// release. It allocates nothing and makes no system calls except those of the clock.
struct PacedLoop {
  double period = 1e-3;                     ///< [s]
  const std::atomic<bool>* stop = nullptr;  ///< checked between ticks
  std::atomic<long>* done = nullptr;        ///< ticks so far, for a progress display
  device::ThreadCounts counts{};            ///< system counters of the thread during its ticks
  device::Clock* clock = &device::monotonic_clock();

  /// Runs up to `ticks` ticks. `work(moment)` performs one tick, writes its position in the scene
  /// to `moment`, and returns false on the last tick.
  template <class Work> LoopEnd run(long ticks, LoopRecord& record, Work&& work) noexcept {
    (void)clock->now();  // the first read of the clock loads its page
    const device::ThreadCounts before = device::thread_counts();
    device::DeadlineClock releases(period, *clock);
    LoopEnd end = LoopEnd::done;
    for (long n = 0; n < ticks && end == LoopEnd::done; ++n) {
      TickTimes times;
      Moment moment;
      times.due = releases.wait();
      times.begin = clock->now();
      const bool more = work(moment);
      times.end = clock->now();
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
