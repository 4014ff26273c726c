// SPDX-License-Identifier: MIT
#include "device/deadline_clock.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>

#include <time.h>

namespace palpate::device {

namespace {

void sleep_until(double time) noexcept {
  const double seconds = std::floor(time);
  const timespec until{static_cast<time_t>(seconds), static_cast<long>(1e9 * (time - seconds))};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {}
}

}  // namespace

double monotonic_now() noexcept {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double DeadlineClock::wait() noexcept {
  const double before = monotonic_now();
  if (facts_.ticks == 0) { begin_ = before; }
  const double due = begin_ + period_ * static_cast<double>(facts_.ticks);
  ++facts_.ticks;
  double after = before;
  while (after < due) {  // a timespec is cut to whole nanoseconds
    sleep_until(due);
    after = monotonic_now();
  }
  if (after > before) { facts_.worst_wake = std::max(facts_.worst_wake, after - due); }
  facts_.slept += after - before;
  facts_.worst_lateness = std::max(facts_.worst_lateness, after - due);
  facts_.missed += after > due + period_ ? 1 : 0;
  return due;
}

}  // namespace palpate::device
