// SPDX-License-Identifier: MIT
#include "device/real_time.hpp"

#include <chrono>
#include <sched.h>
#include <thread>

#include "tests/check.hpp"

namespace {

using namespace palpate::device;

TEST("a thread is kept to the processor it asked for") {
  const std::vector<int> allowed = allowed_processors();
  CHECK(!allowed.empty());
  std::vector<int> kept;
  bool granted = false;
  std::thread([&] {
    granted = pin_to(allowed.back());
    kept = allowed_processors();
  }).join();
  CHECK(granted && kept == std::vector<int>{allowed.back()});
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
  CHECK(during.voluntary_switches >= 1 && during.minor_faults >= 0);
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
