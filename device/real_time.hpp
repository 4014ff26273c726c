// SPDX-License-Identifier: MIT
#pragma once
/// Clocks, ticks at absolute times, and the rights of a thread with deadlines.

#include <string>
#include <vector>

namespace palpate::device {

/// CLOCK_MONOTONIC [s]; good to some nanoseconds for months after the machine's start.
double monotonic_now() noexcept;

/// Time [s] that a thread can read and sleep on.
class Clock {
 public:
  virtual ~Clock() = default;
  [[nodiscard]] virtual double now() noexcept = 0;
  /// Returns at `time` or later; at once if `time` is in the past. Neither allocates nor locks.
  virtual void sleep_until(double time) noexcept = 0;
};

/// CLOCK_MONOTONIC.
Clock& monotonic_clock() noexcept;

/// Time that passes only by sleep_until() and advance(), so that a loop with deadlines runs at once
/// and gives the same times on every machine.
class VirtualClock final : public Clock {
 public:
  [[nodiscard]] double now() noexcept override { return now_; }
  void sleep_until(double time) noexcept override { now_ = time > now_ ? time : now_; }
  void advance(double seconds) noexcept { now_ += seconds; }

 private:
  double now_ = 0.0;
};

struct DeadlineFacts {
  long ticks = 0;
  long missed = 0;              ///< ticks that began after the time of the next one
  double worst_wake = 0.0;      ///< largest delay of a wake-up after a sleep [s]
  double worst_lateness = 0.0;  ///< largest delay of the begin of a tick, slept or not [s]
  double slept = 0.0;           ///< [s]
};

/// Releases ticks at absolute times: a late tick does not delay the releases after it.
class DeadlineClock {
 public:
  /// `period` of the ticks [s]. `clock` must live as long as this object.
  explicit DeadlineClock(double period, Clock& clock = monotonic_clock())
      : period_(period), clock_(clock) {}

  /// Returns when the next tick is due, at once if it is overdue. The first call is tick 0 and due
  /// immediately. Neither allocates nor locks. Returns the time at which the tick was due [s].
  double wait() noexcept;
  [[nodiscard]] const DeadlineFacts& facts() const { return facts_; }

 private:
  double period_;
  Clock& clock_;
  double begin_ = 0.0;  ///< time of tick 0 [s]
  DeadlineFacts facts_{};
};

// Rights of a thread that keeps deadlines: SCHED_FIFO, locked memory, a processor of its own. None
// of these functions fails; the reason of a refusal is returned.

/// Processors that this process may run on, ascending.
std::vector<int> allowed_processors();
/// Restricts the calling thread to the processor or processors. False if the system refuses.
bool pin_to(int processor) noexcept;
bool pin_to(const std::vector<int>& processors) noexcept;
/// Touches the stack of the calling thread, so that later deeper calls cause no page fault.
void touch_stack() noexcept;

/// Locks all memory of the process, present and future, during the lifetime of the object.
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

/// Schedules the calling thread first in, first out (SCHED_FIFO) during the lifetime of the object.
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

/// Counters of the system for the calling thread, since its start.
struct ThreadCounts {
  long minor_faults = 0;
  long major_faults = 0;          ///< page faults that read a disk
  long voluntary_switches = 0;    ///< sleeps
  long involuntary_switches = 0;  ///< preemptions
};
ThreadCounts thread_counts() noexcept;
ThreadCounts operator-(const ThreadCounts& a, const ThreadCounts& b) noexcept;
ThreadCounts& operator+=(ThreadCounts& a, const ThreadCounts& b) noexcept;

}  // namespace palpate::device
