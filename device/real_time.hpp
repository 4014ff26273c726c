// SPDX-License-Identifier: MIT
#pragma once
/// Ticks at absolute times of the wall clock: a late tick does not move the ones after it.

#include <string>
#include <vector>

namespace palpate::device {

/// CLOCK_MONOTONIC [s]; good to some nanoseconds for months after the machine's start.
double monotonic_now() noexcept;

struct DeadlineFacts {
  long ticks = 0;
  long missed = 0;              ///< of them, began after the time of the next one
  double worst_wake = 0.0;      ///< latest wake-up after a sleep [s]
  double worst_lateness = 0.0;  ///< latest begin of a tick, whatever made it late [s]
  double slept = 0.0;           ///< [s]
};

class DeadlineClock {
 public:
  /// `period` [s] of the ticks.
  explicit DeadlineClock(double period) : period_(period) {}

  /// Returns when the next tick is due, at once if it is overdue. The first call is tick 0 and due
  /// immediately. Neither allocates nor locks; sleeps in the kernel. Gives the time at which the
  /// tick was due, on the clock of monotonic_now() [s].
  double wait() noexcept;
  [[nodiscard]] const DeadlineFacts& facts() const { return facts_; }

 private:
  double period_;
  double begin_ = 0.0;  ///< CLOCK_MONOTONIC of tick 0 [s]
  DeadlineFacts facts_{};
};

// What a thread needs to keep deadlines, and what the system grants of it: SCHED_FIFO, memory that
// stays, a processor of its own. Nothing here fails: what is refused is told.

/// Processors that this process may run on, ascending.
std::vector<int> allowed_processors();
/// The calling thread alone; false where the system refuses.
bool pin_to(int processor) noexcept;
bool pin_to(const std::vector<int>& processors) noexcept;
/// Touches the stack of the calling thread, so that a deeper call later finds it there.
void touch_stack() noexcept;

/// All memory of the process, present and future, stays where it is while this lives.
class LockedMemory {
 public:
  LockedMemory() noexcept;
  ~LockedMemory();
  LockedMemory(const LockedMemory&) = delete;
  LockedMemory& operator=(const LockedMemory&) = delete;
  [[nodiscard]] const std::string& refusal() const { return refusal_; }  ///< empty: granted

 private:
  std::string refusal_{};
};

/// The calling thread is scheduled first in, first out, while this lives.
class FifoScheduling {
 public:
  explicit FifoScheduling(int priority) noexcept;
  ~FifoScheduling();
  FifoScheduling(const FifoScheduling&) = delete;
  FifoScheduling& operator=(const FifoScheduling&) = delete;
  [[nodiscard]] int refusal() const { return refusal_; }  ///< errno; 0: granted

 private:
  int refusal_ = 0;
};

/// What the system has counted of the calling thread so far.
struct ThreadCounts {
  long minor_faults = 0;
  long major_faults = 0;          ///< that read a disk
  long voluntary_switches = 0;    ///< sleeps
  long involuntary_switches = 0;  ///< somebody else was let in
};
ThreadCounts thread_counts() noexcept;
ThreadCounts operator-(const ThreadCounts& a, const ThreadCounts& b) noexcept;
ThreadCounts& operator+=(ThreadCounts& a, const ThreadCounts& b) noexcept;

}  // namespace palpate::device
