// SPDX-License-Identifier: MIT

#include "device/real_time.hpp"

#include <chrono>
#include <sched.h>
#include <thread>
#include <unistd.h>

#include "tests/check.hpp"

using namespace palpate::device;

namespace PALPATE_FILE {

TEST("no tick begins before its time, at the rates of the Falcon") {
  for (const double rate : {300.0, 500.0, 1000.0, 2000.0}) {
    DeadlineClock real(1.0 / rate);
    const double begin = monotonic_now();
    for (int n = 0; n < 20; ++n) {
      real.wait();
      CHECK(monotonic_now() >= begin + n / rate);
    }
    CHECK(real.facts().ticks == 20);
  }
}

TEST("a tick of virtual time begins exactly when it is due") {
  VirtualClock time;
  DeadlineClock clock(0.25, time);  // a sum of quarters is exact
  for (int n = 0; n < 100; ++n) {
    CHECK(clock.wait() == 0.25 * n);
    CHECK(time.now() == 0.25 * n);
  }
  CHECK(clock.facts().missed == 0);
  CHECK(clock.facts().worst_lateness == 0.0);
  CHECK(clock.facts().slept == 0.25 * 99);
}

TEST("a tick that takes too long moves none of those after it, and is counted") {
  VirtualClock time;
  DeadlineClock clock(0.25, time);
  clock.wait();
  time.advance(0.875);                           // three periods and a half
  for (int n = 0; n < 3; ++n) { clock.wait(); }  // due at 0.25, 0.5 and 0.75 s: overdue, no sleep
  CHECK(clock.facts().slept == 0.0);
  CHECK(clock.facts().missed == 2);  // those of 0.25 and 0.5 s
  CHECK(clock.facts().worst_lateness == 0.625);
  for (int n = 4; n <= 20; ++n) { clock.wait(); }
  CHECK(time.now() == 5.0);
  CHECK(clock.facts().missed == 2);
}

TEST("a thread is pinned to its processor") {
  const std::vector<int> allowed = allowed_processors();
  REQUIRE(!allowed.empty());
  std::vector<int> kept;
  bool granted = false;
  std::thread([&] {
    granted = pin_to({allowed.back()});
    kept = allowed_processors();
  }).join();
  CHECK(granted);
  CHECK(kept == std::vector<int>{allowed.back()});
  CHECK(allowed_processors() == allowed);  // nobody else's changed
}

TEST("scheduling is first in, first out during its scope, or the refusal is reported") {
  int during = -1;
  int after = -1;
  int refusal = -1;
  std::thread([&] {
    {
      const FifoScheduling fifo(10);
      refusal = fifo.refusal();
      during = sched_getscheduler(0);
    }
    after = sched_getscheduler(0);
  }).join();
  CHECK(during == (refusal == 0 ? SCHED_FIFO : SCHED_OTHER));
  CHECK(after == SCHED_OTHER);
}

TEST("counts only grow, and a sleep is one of them") {
  const ThreadCounts before = thread_counts();
  std::this_thread::sleep_for(std::chrono::milliseconds(2));
  const ThreadCounts during = thread_counts() - before;
  CHECK(during.voluntary_switches >= 1);
  CHECK(during.minor_faults >= 0);
  ThreadCounts sum = before;
  sum += during;
  CHECK(sum.voluntary_switches == before.voluntary_switches + during.voluntary_switches);
}

TEST("locked memory is released, or the refusal is reported") {
  { const LockedMemory locked; }
  const LockedMemory again;  // a second time gives the same answer
  CHECK(again.refusal().empty() == LockedMemory().refusal().empty());
}

TEST("processors stay awake during the lifetime of the object, or the refusal is reported") {
  const auto next_file = [] {
    const int file = ::dup(STDERR_FILENO);
    ::close(file);
    return file;
  };
  const int before = next_file();
  {
    const AwakeProcessors awake;  // the system keeps them awake while the file is open
    CHECK(awake.refusal().empty() == (next_file() > before));
  }
  CHECK(next_file() == before);
}

}  // namespace PALPATE_FILE
