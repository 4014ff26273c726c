// SPDX-License-Identifier: MIT

#include "device/real_time.hpp"

#include <chrono>
#include <sched.h>
#include <thread>

#include "tests/check.hpp"

using namespace palpate::device;
using Clock = std::chrono::steady_clock;

namespace {

double since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

}  // namespace

TEST("no tick begins before its time, at the rates of the Falcon") {
  for (const double rate : {300.0, 500.0, 1000.0, 2000.0}) {
    DeadlineClock clock(1.0 / rate);
    const auto begin = Clock::now();
    const int ticks = static_cast<int>(rate / 10.0);
    for (int n = 0; n < ticks; ++n) {
      clock.wait();
      CHECK(since(begin) >= n / rate);
    }
    CHECK(clock.facts().ticks == ticks);
    CHECK(clock.facts().slept <= since(begin));
  }
}

TEST("a tick that takes too long moves none of those after it, and is counted") {
  DeadlineClock clock(1e-2);
  const auto begin = Clock::now();
  clock.wait();
  std::this_thread::sleep_for(std::chrono::milliseconds(35));
  for (int n = 0; n < 3; ++n) { clock.wait(); }  // due at 10, 20 and 30 ms: overdue, no sleep
  const double slept = clock.facts().slept;
  CHECK_NEAR(slept, 0.0, 1e-4);
  CHECK(clock.facts().missed >= 2);  // those of 10 and 20 ms
  CHECK(clock.facts().worst_lateness >= 25e-3);
  for (int n = 4; n <= 20; ++n) { clock.wait(); }
  CHECK(since(begin) >= 0.2);
}

namespace {

using namespace palpate::device;

TEST("a thread is kept to the processor it asked for") {
  const std::vector<int> allowed = allowed_processors();
  REQUIRE(!allowed.empty());
  std::vector<int> kept;
  bool granted = false;
  std::thread([&] {
    granted = pin_to(allowed.back());
    kept = allowed_processors();
  }).join();
  CHECK(granted);
  CHECK(kept == std::vector<int>{allowed.back()});
  CHECK(allowed_processors() == allowed);  // nobody else's changed
}

TEST("scheduling is first in, first out while asked for, or the refusal is told") {
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

TEST("locked memory is let go, or the refusal is told") {
  { const LockedMemory locked; }
  const LockedMemory again;  // a second time gives the same answer
  CHECK(again.refusal().empty() == LockedMemory().refusal().empty());
}

}  // namespace
