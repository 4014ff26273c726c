// SPDX-License-Identifier: MIT
#include "validation/certificate/loop_record.hpp"

#include <algorithm>
#include <random>

#include "tests/check.hpp"

namespace {

using namespace palpate;
using namespace palpate::certificate;

TEST("response is wake-up and computation, from the release that was scheduled") {
  LoopRecord record(1e-3);
  record.add({.due = 5.0, .begin = 5.0002, .end = 5.0005}, {.scene_time = 1.5});
  CHECK_NEAR(record.worst_wakeup.seconds, 2e-4, 1e-12);
  CHECK_NEAR(record.worst_compute.seconds, 3e-4, 1e-12);
  CHECK_NEAR(record.worst_response.seconds, 5e-4, 1e-12);
  CHECK_NEAR(record.worst_response.moment.scene_time, 1.5, 0.0);
  CHECK(record.misses.count() == 0);
}

TEST("one long tick makes all those late that wait behind it: nothing is omitted") {
  LoopRecord record(1e-3);
  // Tick 0 takes 3.5 ms; 1, 2 and 3 begin at once after it and take 0.1 ms each, 4 is in time again.
  double free = 0.0;
  for (int n = 0; n < 6; ++n) {
    const double due = 1e-3 * n;
    const double begin = std::max(due, free);
    free = begin + (n == 0 ? 3.5e-3 : 1e-4);
    record.add({.due = due, .begin = begin, .end = free}, {});
  }
  CHECK(record.misses.count() == 3);  // answers after 3.5, 2.6 and 1.7 ms; then 0.8
  CHECK(record.misses.longest_run() == 3);
  CHECK_NEAR(record.misses.longest_recovery(), 3.8e-3, 1e-12);  // until tick 3 was done in time
  CHECK(record.worst_response.tick == 0);
  CHECK(record.worst_wakeup.tick == 1);
}

TEST("a response that is no number is a miss, and exactly the deadline is none") {
  LoopRecord record(0.5);
  record.add({.due = 0.0, .begin = 0.0, .end = 0.5}, {});
  CHECK(record.misses.count() == 0);
  record.add({.due = 0.0, .begin = 0.0, .end = std::nan("")}, {});
  CHECK(record.misses.count() == 1);
}

TEST("the largest are kept, with their ticks, whatever the order they come in") {
  std::vector<LargeTick> all;
  for (long n = 0; n < 5000; ++n) { all.push_back({1e-6 * static_cast<double>(n), n}); }
  std::ranges::shuffle(all, std::mt19937(3));
  LargestTicks largest(100);
  for (const LargeTick& each : all) { largest.add(each); }
  const std::vector<LargeTick> kept = largest.sorted();
  CHECK(kept.size() == 100);
  for (long n = 0; n < 100; ++n) { CHECK(kept[static_cast<std::size_t>(n)].tick == 4999 - n); }
}

TEST("what happened to the tool stands with the longest tick") {
  LoopRecord record(1.0);
  record.add({.due = 0.0, .begin = 0.0, .end = 0.2},
             {.scene_time = 0.3, .happening = ToolHappening{.event = ToolEvent::puncture}});
  record.add({.due = 1.0, .begin = 1.0, .end = 1.1}, {});
  CHECK(record.worst_compute.moment.happening &&
        record.worst_compute.moment.happening->event == ToolEvent::puncture);
}

}  // namespace
