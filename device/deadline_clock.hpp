// SPDX-License-Identifier: MIT
#pragma once
/// Ticks at absolute times of the wall clock: a late tick does not move the ones after it.

namespace palpate::device {

/// CLOCK_MONOTONIC [s]; good to some nanoseconds for months after the machine's start.
double monotonic_now() noexcept;

struct DeadlineFacts {
  long ticks = 0;
  long missed = 0;                ///< of them, began after the time of the next one
  double worst_wake = 0.0;        ///< latest wake-up after a sleep [s]
  double worst_lateness = 0.0;    ///< latest begin of a tick, whatever made it late [s]
  double slept = 0.0;             ///< [s]
};

class DeadlineClock {
 public:
  /// `period` [s] of the ticks.
  explicit DeadlineClock(double period) : period_(period) {}

  /// Returns when the next tick is due, at once if it is overdue. The first call is tick 0 and due
  /// immediately. Neither allocates nor locks; sleeps in the kernel. Gives the time at which the tick was
  /// due, on the clock of monotonic_now() [s].
  double wait() noexcept;
  [[nodiscard]] const DeadlineFacts& facts() const { return facts_; }

 private:
  double period_;
  double begin_ = 0.0;  ///< CLOCK_MONOTONIC of tick 0 [s]
  DeadlineFacts facts_{};
};

}  // namespace palpate::device
