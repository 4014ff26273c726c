// SPDX-License-Identifier: MIT
#pragma once
/// Times in bins of 1 us: the memory of a day is that of a second. After construction nothing is
/// allocated.

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
  static constexpr double bin_width = 1e-6;         ///< [s]
  static constexpr std::size_t bin_count = 100000;  ///< the last one holds all from 0.1 s on

  LatencyHistogram() : counts_(bin_count, 0) {}

  void add(double seconds) noexcept;

  [[nodiscard]] long count() const { return count_; }
  [[nodiscard]] double minimum() const { return minimum_; }  ///< [s]; 0 without any
  [[nodiscard]] double maximum() const { return maximum_; }  ///< [s]; 0 without any
  [[nodiscard]] std::span<const std::uint32_t> counts() const { return counts_; }
  /// Bins up to the last one that holds any.
  [[nodiscard]] std::size_t used_bins() const;
  /// The time [s] that this share of all does not exceed: the end of the bin of the ordered sample
  /// at ceil(share n), so up to 1 us too long and never too short; beyond the bins the maximum.
  /// Nothing where no sample lies above it, that is, where fewer than 1 / (1 - share) are there.
  [[nodiscard]] std::optional<double> percentile(double share) const;

 private:
  std::vector<std::uint32_t> counts_;
  long count_ = 0;
  double minimum_ = 0.0;
  double maximum_ = 0.0;
};

// What a loop with deadlines leaves: times of every tick, and its misses. All from the release that
// was scheduled, never from the actual start, so that a late tick is charged to whoever made it
// late.

/// Where in the scene a tick was.
struct Moment {
  double scene_time = 0.0;                   ///< [s]
  std::optional<ToolHappening> happening{};  ///< in this tick; the last of several
};

/// Instants of one tick [s].
struct TickTimes {
  double due = 0.0;    ///< its release
  double begin = 0.0;  ///< when it was awake
  double end = 0.0;    ///< when its work was done
};

/// The longest of a kind, and when it was.
struct Peak {
  double seconds = -1.0;  ///< below 0: none yet
  long tick = 0;
  Moment moment{};
};

/// Ticks whose response took longer than the deadline.
class Misses {
 public:
  void add(bool missed, const TickTimes& times) noexcept;
  [[nodiscard]] long count() const { return count_; }
  [[nodiscard]] long longest_run() const { return longest_run_; }
  /// Longest time from the release of a first missed tick until a tick was in time again [s].
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

/// The largest of all so far, at most `capacity`; never allocates after construction.
class LargestTicks {
 public:
  explicit LargestTicks(std::size_t capacity);
  void add(const LargeTick& tick) noexcept;
  [[nodiscard]] std::vector<LargeTick> sorted() const;  ///< largest first

 private:
  std::size_t capacity_;
  std::vector<LargeTick> heap_{};  ///< the least on top
};

/// Response times that are kept for the tail.
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

/// A loop that is later than this is ended: it will not catch up in useful time [s].
inline constexpr double hopeless_lateness = 2.0;

enum class LoopEnd {
  done,      ///< as many ticks as were asked for
  over,      ///< the work said that nothing is left of it
  stopped,   ///< Ctrl-C
  hopeless,  ///< later than hopeless_lateness
};

/// Loop with absolute deadlines: it is woken at every release, works, and sleeps until the next
/// release. It allocates nothing and makes no system call but those of the clock.
struct PacedLoop {
  double period = 1e-3;                     ///< [s]
  const std::atomic<bool>* stop = nullptr;  ///< looked at between ticks
  std::atomic<long>* done = nullptr;        ///< ticks so far, for whoever shows progress
  device::ThreadCounts counts{};            ///< of what the system did to the thread in its ticks
  device::Clock* clock = &device::monotonic_clock();

  /// `work(moment)` is one tick, tells where in the scene it was, and is false where it was the
  /// last one.
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
