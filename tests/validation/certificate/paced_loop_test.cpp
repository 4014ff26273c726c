// SPDX-License-Identifier: MIT

#include "validation/certificate/paced_loop.hpp"

#include <chrono>
#include <random>
#include <thread>

#include "device/real_time.hpp"
#include "tests/check.hpp"
#include "validation/certificate/background_load.hpp"

namespace {

using namespace palpate::certificate;
using namespace palpate;
using palpate::certificate::LatencyHistogram;

LatencyHistogram histogram_of(int count, double first, double step) {
  LatencyHistogram histogram;
  for (int n = 0; n < count; ++n) { histogram.add(first + step * n); }
  return histogram;
}

TEST("a percentile is the end of the bin of its ordered sample") {
  const LatencyHistogram histogram = histogram_of(1000, 0.5e-6, 1e-6);  // one in each of 1000 bins
  CHECK_NEAR(*histogram.percentile(0.5), 500e-6, 1e-15);  // the 500th value, in [499, 500) us
  CHECK_NEAR(*histogram.percentile(0.99), 990e-6, 1e-15);
  CHECK_NEAR(*histogram.percentile(0.999), 999e-6, 1e-15);
  CHECK_NEAR(histogram.minimum(), 0.5e-6, 1e-20);
  CHECK_NEAR(histogram.maximum(), 999.5e-6, 1e-18);
  CHECK(histogram.used_bins() == 1000);
}

TEST("a percentile exists if a sample lies above it, and is never beyond the maximum") {
  const LatencyHistogram equal = histogram_of(1000, 100.2e-6, 0.0);
  CHECK(equal.percentile(0.999).has_value());
  CHECK(!equal.percentile(0.9999).has_value());
  CHECK(!LatencyHistogram().percentile(0.5).has_value());
  CHECK_NEAR(*equal.percentile(0.5), 100.2e-6, 1e-15);
  const LatencyHistogram beyond = histogram_of(10, 0.2, 0.1);  // beyond all bins
  CHECK(beyond.counts().back() == 10);
  CHECK_NEAR(*beyond.percentile(0.5), 1.1, 1e-12);
  // NaN is counted as the longest latency, and a negative one, of a clock read twice, as shortest.
  LatencyHistogram unusual;
  unusual.add(std::nan(""));
  unusual.add(-1e-9);
  CHECK(unusual.counts().back() == 1);
  CHECK(unusual.counts().front() == 1);
  CHECK(unusual.count() == 2);
}

TEST("a response is wake-up and computation; the longest is kept with its scene time and event") {
  LoopRecord record(1e-3);
  record.add({.due = 5.0, .begin = 5.0002, .end = 5.0005},
             {.scene_time = 1.5, .happening = ToolHappening{.event = ToolEvent::puncture}});
  record.add({.due = 6.0, .begin = 6.0, .end = 6.0001}, {});
  CHECK_NEAR(record.worst_wakeup.seconds, 2e-4, 1e-12);
  CHECK_NEAR(record.worst_compute.seconds, 3e-4, 1e-12);
  CHECK_NEAR(record.worst_response.seconds, 5e-4, 1e-12);
  CHECK_NEAR(record.worst_response.moment.scene_time, 1.5, 0.0);
  REQUIRE(record.worst_compute.moment.happening.has_value());
  CHECK(record.worst_compute.moment.happening->event == ToolEvent::puncture);
  CHECK(record.misses.count() == 0);
  record.add({.due = 0.0, .begin = 0.0, .end = 1e-3}, {});  // exactly the deadline
  CHECK(record.misses.count() == 0);
  record.add({.due = 0.0, .begin = 0.0, .end = std::nan("")}, {});
  CHECK(record.misses.count() == 1);
}

TEST("the largest ticks are kept, whatever their order") {
  std::vector<LargeTick> all;
  for (long n = 0; n < 5000; ++n) { all.push_back({1e-6 * static_cast<double>(n), n}); }
  std::ranges::shuffle(all, std::mt19937(3));
  LargestTicks largest(100);
  for (const LargeTick& each : all) { largest.add(each); }
  const std::vector<LargeTick> kept = largest.sorted();
  REQUIRE(kept.size() == 100);
  for (long n = 0; n < 100; ++n) { CHECK(kept[static_cast<std::size_t>(n)].tick == 4999 - n); }
}

TEST("every load but idle works until it is destroyed, and other names are no loads") {
  const std::vector<int> processors = device::allowed_processors();
  for (const char* name : {"cpu", "cache", "memory"}) {
    BackgroundLoad load(name, {processors.back()}, 1U << 20U);
    while (load.rounds() < 2) { std::this_thread::yield(); }  // CTest ends a load that never works
    CHECK(load.threads() == 1);
    CHECK(load.rounds() >= 2);
  }
  CHECK(BackgroundLoad("idle", processors, 1U << 20U).threads() == 0);
  CHECK(is_own_load("idle"));
  CHECK(is_own_load("memory"));
  CHECK(!is_own_load("gpu"));
  CHECK(!is_own_load(""));
}

/// Loop in virtual time.
struct Paced {
  explicit Paced(double period) : record(period), loop{.period = period, .clock = &time} {}
  template <class Work> LoopEnd run(long ticks, Work work) { return loop.run(ticks, record, work); }

  device::VirtualClock time{};
  LoopRecord record;
  PacedLoop loop;
};

TEST("every release is served once, in order, and at its time, not before it on the real clock") {
  Paced paced(0.25);
  long calls = 0;
  CHECK(paced.run(50, [&](Moment&) { return ++calls > 0; }) == LoopEnd::done);
  CHECK(calls == 50);
  CHECK(paced.record.ticks() == 50);
  CHECK(paced.time.now() == 49 * 0.25);
  CHECK(paced.record.wakeup.minimum() == 0.0);
  CHECK(paced.record.wakeup.maximum() == 0.0);
  PacedLoop real{.period = 2e-3};
  LoopRecord record(2e-3);
  real.run(10, record, [](Moment&) { return true; });
  CHECK(record.wakeup.minimum() >= 0.0);
}

TEST("one long tick also delays the following ticks, and all of them are late") {
  Paced paced(0.25);
  paced.run(20, [&](Moment&) {
    if (paced.record.ticks() == 5) { paced.time.advance(0.875); }
    return true;
  });
  const LoopRecord& record = paced.record;
  CHECK(record.misses.count() == 3);  // answers after 0.875, 0.625 and 0.375 s; then 0.125 s
  CHECK(record.misses.longest_run() == 3);
  CHECK(record.misses.longest_recovery() == 0.875);  // until a tick was done in time
  CHECK(record.worst_compute.tick == 5);
  CHECK(record.worst_response.tick == 5);
  CHECK(record.worst_wakeup.tick == 6);
  CHECK(record.worst_wakeup.seconds == 0.625);
}

TEST("the last work and Ctrl-C end the loop after their tick") {
  Paced paced(1e-3);
  CHECK(paced.run(100, [&](Moment&) { return paced.record.ticks() < 6; }) == LoopEnd::over);
  CHECK(paced.record.ticks() == 7);
  std::atomic<bool> stop{false};
  paced.loop.stop = &stop;
  CHECK(paced.run(100, [&](Moment&) {
    stop = paced.record.ticks() == 9;
    return true;
  }) == LoopEnd::stopped);
  CHECK(paced.record.ticks() == 10);
}

TEST("a loop that is two seconds late ends as hopeless") {
  Paced paced(0.125);
  CHECK(paced.run(1000, [&](Moment&) {
    paced.time.advance(0.625);
    return true;
  }) == LoopEnd::hopeless);
  CHECK(paced.record.ticks() == 4);  // each half a second later than the last; the limit is 2 s
}

}  // namespace
