// SPDX-License-Identifier: MIT

#include "validation/certificate/paced_loop.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <random>
#include <thread>

#include "device/real_time.hpp"
#include "tests/check.hpp"
#include "validation/certificate/background_load.hpp"

namespace {

using namespace palpate::certificate;
using namespace palpate;
using palpate::certificate::LatencyHistogram;

TEST("a percentile is the end of the bin of its ordered sample") {
  LatencyHistogram histogram;
  for (int n = 1; n <= 1000; ++n) {
    histogram.add(1e-6 * (n - 0.5));
  }  // one in every bin from 0 to 999
  CHECK_NEAR(*histogram.percentile(0.5), 500e-6,
             1e-15);  // number 500 of 1000 ordered values, in [499, 500) us
  CHECK_NEAR(*histogram.percentile(0.99), 990e-6, 1e-15);
  CHECK_NEAR(*histogram.percentile(0.999), 999e-6, 1e-15);
  CHECK_NEAR(histogram.minimum(), 0.5e-6, 1e-20);
  CHECK_NEAR(histogram.maximum(), 999.5e-6, 1e-18);
  CHECK(histogram.used_bins() == 1000);
}

TEST("a percentile that no sample lies above is not invented") {
  LatencyHistogram histogram;
  for (int n = 0; n < 1000; ++n) { histogram.add(1e-4); }
  CHECK(histogram.percentile(0.999).has_value());
  CHECK(!histogram.percentile(0.9999).has_value());
  CHECK(!LatencyHistogram().percentile(0.5).has_value());
}

TEST("a percentile is never beyond the maximum") {
  LatencyHistogram histogram;
  for (int n = 0; n < 10; ++n) { histogram.add(100.2e-6); }
  CHECK_NEAR(*histogram.percentile(0.5), 100.2e-6, 1e-15);
}

TEST("what is beyond all bins is counted in the last one, and its percentile is the maximum") {
  LatencyHistogram histogram;
  for (int n = 0; n < 10; ++n) { histogram.add(0.2 + 0.1 * n); }
  CHECK(histogram.counts().back() == 10);
  CHECK_NEAR(*histogram.percentile(0.5), 1.1, 1e-12);
}

TEST("no number is lost among the short ones") {
  LatencyHistogram histogram;
  histogram.add(std::numeric_limits<double>::quiet_NaN());
  histogram.add(-1e-9);  // a clock that is read twice
  CHECK(histogram.counts().back() == 1);
  CHECK(histogram.counts().front() == 1);
  CHECK(histogram.count() == 2);
}

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
  // Tick 0 takes 3.5 ms. Ticks 1, 2 and 3 start immediately after it and take 0.1 ms each; tick 4
  // is on time.
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
  REQUIRE(kept.size() == 100);
  for (long n = 0; n < 100; ++n) { CHECK(kept[static_cast<std::size_t>(n)].tick == 4999 - n); }
}

TEST("what happened to the tool stands with the longest tick") {
  LoopRecord record(1.0);
  record.add({.due = 0.0, .begin = 0.0, .end = 0.2},
             {.scene_time = 0.3, .happening = ToolHappening{.event = ToolEvent::puncture}});
  record.add({.due = 1.0, .begin = 1.0, .end = 1.1}, {});
  CHECK(record.worst_compute.moment.happening);
  CHECK(record.worst_compute.moment.happening->event == ToolEvent::puncture);
}

TEST("every load but idle works until it is gone") {
  const std::vector<int> processors = palpate::device::allowed_processors();
  for (const char* name : {"cpu", "cache", "memory"}) {
    BackgroundLoad load(name, {processors.back()}, 1U << 20U);
    while (load.rounds() < 2) { std::this_thread::yield(); }  // CTest ends a load that never works
    CHECK(load.threads() == 1);
    CHECK(load.rounds() >= 2);
  }
  CHECK(BackgroundLoad("idle", processors, 1U << 20U).threads() == 0);
}

TEST("names that are no load are known as such") {
  CHECK(is_own_load("idle"));
  CHECK(is_own_load("memory"));
  CHECK(!is_own_load("gpu"));
  CHECK(!is_own_load(""));
}

TEST("every release is met once, in order, and at its time") {
  palpate::device::VirtualClock time;
  PacedLoop loop{.period = 0.25, .clock = &time};
  LoopRecord record(0.25);
  long calls = 0;
  const LoopEnd end = loop.run(50, record, [&](Moment&) { return ++calls > 0; });
  CHECK(end == LoopEnd::done);
  CHECK(calls == 50);
  CHECK(record.ticks() == 50);
  CHECK(time.now() == 49 * 0.25);
  CHECK(record.wakeup.minimum() == 0.0);
  CHECK(record.wakeup.maximum() == 0.0);
}

TEST("none is met before its time on the real clock") {
  PacedLoop loop{.period = 2e-3};
  LoopRecord record(2e-3);
  loop.run(10, record, [](Moment&) { return true; });
  CHECK(record.wakeup.minimum() >= 0.0);
}

TEST("a tick that takes three periods is a miss, and so are those that wait for it") {
  palpate::device::VirtualClock time;
  PacedLoop loop{.period = 0.25, .clock = &time};
  LoopRecord record(0.25);
  long n = 0;
  loop.run(20, record, [&](Moment&) {
    if (n++ == 5) { time.advance(0.875); }
    return true;
  });
  CHECK(record.misses.count() == 3);  // answers after 0.875, 0.625 and 0.375 s; then 0.125 s
  CHECK(record.misses.longest_run() == 3);
  CHECK(record.worst_compute.tick == 5);
  CHECK(record.worst_wakeup.seconds == 0.625);
}

TEST("work that says it was the last, and Ctrl-C, end the loop after that tick") {
  palpate::device::VirtualClock time;
  LoopRecord record(1.0);
  PacedLoop loop{.period = 1e-3, .clock = &time};
  long n = 0;
  CHECK(loop.run(100, record, [&](Moment&) { return ++n < 7; }) == LoopEnd::over);
  CHECK(record.ticks() == 7);
  std::atomic<bool> stop{false};
  loop.stop = &stop;
  n = 0;
  CHECK(loop.run(100, record, [&](Moment&) {
    stop = ++n == 3;
    return true;
  }) == LoopEnd::stopped);
  CHECK(record.ticks() == 10);
}

TEST("a loop that cannot keep up is given up") {
  palpate::device::VirtualClock time;
  PacedLoop loop{.period = 0.125, .clock = &time};
  LoopRecord record(0.125);
  const LoopEnd end = loop.run(1000, record, [&](Moment&) {
    time.advance(0.625);
    return true;
  });
  CHECK(end == LoopEnd::hopeless);
  CHECK(record.ticks() == 4);  // each is half a second later than the one before; the limit is 2 s
}

}  // namespace
