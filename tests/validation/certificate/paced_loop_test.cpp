// SPDX-License-Identifier: MIT
#include "validation/certificate/paced_loop.hpp"

#include <chrono>
#include <thread>

#include "tests/check.hpp"

namespace {

using namespace palpate::certificate;

TEST("every release is met once, in order, and none before its time") {
  PacedLoop loop{.period = 2e-3};
  LoopRecord record(2e-3);
  long calls = 0;
  const double begin = palpate::device::monotonic_now();
  const LoopEnd end = loop.run(50, record, [&](Moment&) { return ++calls > 0; });
  CHECK(end == LoopEnd::done && calls == 50 && record.ticks() == 50);
  CHECK(palpate::device::monotonic_now() - begin >= 49 * 2e-3);
  CHECK(record.wakeup.minimum() >= 0.0);
}

TEST("a tick that takes three periods is a miss, and so are those that wait for it") {
  PacedLoop loop{.period = 10e-3};
  LoopRecord record(10e-3);
  long n = 0;
  loop.run(20, record, [&](Moment&) {
    if (n++ == 5) { std::this_thread::sleep_for(std::chrono::milliseconds(35)); }
    return true;
  });
  CHECK(record.misses.longest_run() >= 3);  // answers after 35, 25 and 15 ms
  CHECK(record.worst_compute.tick == 5);
  CHECK(record.worst_wakeup.seconds >= 25e-3);
}

TEST("work that says it was the last, and Ctrl-C, end the loop after that tick") {
  LoopRecord record(1.0);
  PacedLoop loop{.period = 1e-3};
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
  PacedLoop loop{.period = 50e-3};
  LoopRecord record(50e-3);
  const LoopEnd end = loop.run(1000, record, [](Moment&) {
    std::this_thread::sleep_for(std::chrono::milliseconds(550));
    return true;
  });
  CHECK(end == LoopEnd::hopeless);
  CHECK(record.ticks() <= 5);  // each is half a second later than the one before
}

}  // namespace
