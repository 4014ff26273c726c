// SPDX-License-Identifier: MIT
#pragma once
/// Clocks, ticks at absolute times, and the rights of a thread with deadlines.

#include <string>
#include <vector>

namespace palpate::device {

/// Returns CLOCK_MONOTONIC [s], with a resolution of some nanoseconds for months after system
/// start.
double monotonic_now() noexcept;

/// Interface of a clock that a thread can read and sleep on [s].
class Clock {
 public:
  virtual ~Clock() = default;
  [[nodiscard]] virtual double now() noexcept = 0;
  /// Returns at `time` [s] or later; at once if `time` is in the past. Must not allocate or lock.
  virtual void sleep_until(double time) noexcept = 0;
};

/// Returns the clock that uses CLOCK_MONOTONIC.
Clock& monotonic_clock() noexcept;

/// Clock that advances only by sleep_until() and advance(). A loop with deadlines then runs without
/// delay and gives the same times on every machine.
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
  double worst_lateness = 0.0;  ///< largest delay of the start of a tick [s]
  double slept = 0.0;           ///< total sleep time [s]
};

/// Timer that releases ticks at absolute times: a late tick does not delay later releases.
class DeadlineClock {
 public:
  /// `period` is the tick period [s]. `clock` must outlive this object.
  explicit DeadlineClock(double period, Clock& clock = monotonic_clock())
      : period_(period), clock_(clock) {}

  /// Waits for the next tick and returns the time at which it was due [s]. Returns at once if the
  /// tick is overdue. The first call is tick 0 and due immediately. Does not allocate or lock.
  double wait() noexcept;
  /// Delays all later releases by these seconds: time that the ticks do not make up.
  void put_off(double seconds) noexcept { begin_ += seconds; }
  [[nodiscard]] const DeadlineFacts& facts() const { return facts_; }
  [[nodiscard]] double now() const noexcept { return clock_.now(); }  ///< [s]

 private:
  double period_;
  Clock& clock_;
  double begin_ = 0.0;  ///< time of tick 0 [s]
  DeadlineFacts facts_{};
};

// Privileges of a thread with deadlines: SCHED_FIFO, locked memory, a reserved processor,
// processors that do not idle deeply. No function throws; the reason of a refusal is returned.

/// Returns the processors that this process may run on, ascending.
std::vector<int> allowed_processors();
/// Restricts the calling thread to these processors. Returns false if the system refuses.
bool pin_to(const std::vector<int>& processors) noexcept;
/// Touches the stack of the calling thread, so that later deep calls cause no page fault.
void touch_stack() noexcept;

/// Locks all present and future memory of the process during the lifetime of the object.
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

/// Keeps all processors out of idle states that take time to leave, during the lifetime of the
/// object (Linux: /dev/cpu_dma_latency, 0 us).
class AwakeProcessors {
 public:
  AwakeProcessors() noexcept;
  ~AwakeProcessors();
  AwakeProcessors(const AwakeProcessors&) = delete;
  AwakeProcessors& operator=(const AwakeProcessors&) = delete;
  [[nodiscard]] const std::string& refusal() const { return refusal_; }  ///< empty: granted

 private:
  int file_ = -1;
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

/// System counters of the calling thread since its start.
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
