// SPDX-License-Identifier: MIT
#pragma once
/// What a loop with deadlines leaves: times of every tick, and its misses. All from the release that was
/// scheduled, never from the actual start, so that a late tick is charged to whoever made it late.

#include <optional>
#include <span>
#include <vector>

#include "model/stepping/tool_forces.hpp"
#include "validation/certificate/latency_histogram.hpp"

namespace palpate::certificate {

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

}  // namespace palpate::certificate
