// SPDX-License-Identifier: MIT

#include "device/bounded_queue.hpp"

#include <thread>

#include "tests/check.hpp"

namespace {

using palpate::device::HandoverQueue;
using palpate::device::LatestValue;

/// Value that is written and read completely or not at all: both halves are equal.
struct Pair {
  std::int64_t first = 0;
  std::array<std::int64_t, 7> between{};
  std::int64_t last = 0;
};

constexpr std::int64_t items = 300000;

TEST("a queue is first in, first out, and refuses what has no room") {
  HandoverQueue<int, 4> queue;
  CHECK(!queue.pop().has_value());
  for (int n = 0; n < 4; ++n) { CHECK(queue.push(n)); }
  CHECK(!queue.push(4));
  for (int n = 0; n < 4; ++n) { CHECK(queue.pop() == n); }
  CHECK(!queue.pop().has_value());
  for (int n = 0; n < 1000; ++n) {
    CHECK(queue.push(n));
    CHECK(queue.push(-n));
    CHECK(queue.pop() == n);
    CHECK(queue.pop() == -n);
  }
}

TEST("between two threads nothing is lost, doubled, torn or out of order") {
  HandoverQueue<Pair, 64> queue;
  std::thread producer([&] {
    for (std::int64_t n = 0; n < items; ++n) {
      while (!queue.push({.first = n, .last = n})) { std::this_thread::yield(); }
    }
  });
  std::int64_t expected = 0;
  bool good = true;
  while (expected < items) {
    const std::optional<Pair> pair = queue.pop();
    if (!pair) {
      std::this_thread::yield();
      continue;
    }
    good = good && pair->first == expected && pair->last == expected;
    ++expected;
  }
  producer.join();
  CHECK(good);
  CHECK(!queue.pop().has_value());
}

TEST("the latest value is the default, then the value set last, at every read") {
  LatestValue<int> latest;
  CHECK(latest.get() == 0);
  CHECK(latest.get() == 0);
  for (int n = 1; n < 100; ++n) {
    latest.set(n);
    if (n % 3 == 0) {
      CHECK(latest.get() == n);
      CHECK(latest.get() == n);
    }
  }
  CHECK(latest.get() == 99);
}

TEST("a latest value from another thread is whole and never older than the one before") {
  LatestValue<Pair> latest;
  std::atomic<bool> finished{false};
  std::thread producer([&] {
    for (std::int64_t n = 1; n <= items; ++n) { latest.set({.first = n, .last = n}); }
    finished = true;
  });
  std::int64_t before = 0;
  bool good = true;
  for (bool last_look = false; !last_look;) {
    last_look = finished;
    const Pair& pair = latest.get();
    good = good && pair.first == pair.last && pair.first >= before;
    before = pair.first;
  }
  producer.join();
  CHECK(good);
  CHECK(before == items);
}

}  // namespace
