// SPDX-License-Identifier: MIT

#include "device/real_time.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

namespace palpate::device {

namespace {

class MonotonicClock final : public Clock {
 public:
  [[nodiscard]] double now() noexcept override { return monotonic_now(); }
  void sleep_until(double time) noexcept override {
    while (now() < time) {  // a timespec is truncated to whole nanoseconds
      const double seconds = std::floor(time);
      const timespec until{static_cast<time_t>(seconds), static_cast<long>(1e9 * (time - seconds))};
      while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {}
    }
  }
};

MonotonicClock the_monotonic_clock;

}  // namespace

Clock& monotonic_clock() noexcept { return the_monotonic_clock; }

double monotonic_now() noexcept {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double DeadlineClock::wait() noexcept {
  const double before = clock_.now();
  if (facts_.ticks == 0) { begin_ = before; }
  const double due = begin_ + period_ * static_cast<double>(facts_.ticks);
  ++facts_.ticks;
  double after = before;
  if (before < due) {
    clock_.sleep_until(due);
    after = clock_.now();
  }
  if (after > before) { facts_.worst_wake = std::max(facts_.worst_wake, after - due); }
  facts_.slept += after - before;
  facts_.worst_lateness = std::max(facts_.worst_lateness, after - due);
  facts_.missed += after > due + period_ ? 1 : 0;
  return due;
}

std::vector<int> allowed_processors() {
  cpu_set_t set;
  CPU_ZERO(&set);
  std::vector<int> allowed;
  if (sched_getaffinity(0, sizeof set, &set) != 0) { return allowed; }
  for (int n = 0; n < CPU_SETSIZE; ++n) {
    if (CPU_ISSET(n, &set)) { allowed.push_back(n); }
  }
  return allowed;
}

bool pin_to(const std::vector<int>& processors) noexcept {
  cpu_set_t set;
  CPU_ZERO(&set);
  for (const int n : processors) { CPU_SET(n, &set); }
  return pthread_setaffinity_np(pthread_self(), sizeof set, &set) == 0;
}

void touch_stack() noexcept {
  constexpr std::size_t bytes = std::size_t{256} << 10U;
  constexpr std::size_t page = 4096;
  std::array<char, bytes> stack;
  volatile char* const touched = stack.data();
  for (std::size_t n = 0; n < bytes; n += page) { touched[n] = 0; }
}

LockedMemory::LockedMemory() noexcept {
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) { refusal_ = std::strerror(errno); }
}

LockedMemory::~LockedMemory() {
  if (refusal_.empty()) { munlockall(); }
}

AwakeProcessors::AwakeProcessors() noexcept {
  constexpr std::int32_t latency = 0;  // [us]
  file_ = ::open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC);
  if (file_ < 0 || ::write(file_, &latency, sizeof latency) != ssize_t{sizeof latency}) {
    refusal_ = std::strerror(errno);
  }
}

AwakeProcessors::~AwakeProcessors() {
  if (file_ >= 0) { ::close(file_); }
}

FifoScheduling::FifoScheduling(int priority) noexcept {
  const sched_param wanted{.sched_priority = priority};
  refusal_ = pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted);
}

FifoScheduling::~FifoScheduling() {
  const sched_param none{.sched_priority = 0};
  if (refusal_ == 0) { pthread_setschedparam(pthread_self(), SCHED_OTHER, &none); }
}

ThreadCounts thread_counts() noexcept {
  rusage use{};
  getrusage(RUSAGE_THREAD, &use);
  return {.minor_faults = use.ru_minflt,
          .major_faults = use.ru_majflt,
          .voluntary_switches = use.ru_nvcsw,
          .involuntary_switches = use.ru_nivcsw};
}

ThreadCounts operator-(const ThreadCounts& a, const ThreadCounts& b) noexcept {
  return {.minor_faults = a.minor_faults - b.minor_faults,
          .major_faults = a.major_faults - b.major_faults,
          .voluntary_switches = a.voluntary_switches - b.voluntary_switches,
          .involuntary_switches = a.involuntary_switches - b.involuntary_switches};
}

ThreadCounts& operator+=(ThreadCounts& a, const ThreadCounts& b) noexcept {
  a.minor_faults += b.minor_faults;
  a.major_faults += b.major_faults;
  a.voluntary_switches += b.voluntary_switches;
  a.involuntary_switches += b.involuntary_switches;
  return a;
}

}  // namespace palpate::device
