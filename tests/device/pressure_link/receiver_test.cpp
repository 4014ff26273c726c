// SPDX-License-Identifier: MIT
// Tick of a consumer while the reading thread is idle, flooded or stalled.

#include "device/pressure_link/receiver.hpp"

#include <memory>

#include "device/pressure_link/transducer.hpp"
#include "tests/allocation_count.hpp"
#include "tests/check.hpp"
#include "tests/system_call_filter.hpp"

namespace PALPATE_FILE {

using namespace palpate::device;
using namespace palpate::device::pressure_link;
using check::Verdict;

/// Byte link whose reader blocks until released, or reads frames at its own rate.
class StagedLink final : public ByteLink {
 public:
  enum class Act { silent, flood, stall };
  explicit StagedLink(Act act) : act_(act) {}

  [[nodiscard]] double now() const noexcept override { return 1e-3 * double(reads_.load()); }
  bool wait_until(double) noexcept override {
    if (act_ == Act::flood) { return true; }
    ::usleep(act_ == Act::stall ? 500000 : 1000);
    return false;
  }
  std::size_t read(std::span<std::uint8_t> into) noexcept override {
    ++reads_;
    if (act_ != Act::flood) { return 0; }
    std::size_t filled = 0;
    while (filled + frame_bytes <= into.size()) {
      const FrameBytes one = encode({.sequence = sequence_, .pressure = sequence_});
      ++sequence_;
      for (const std::uint8_t byte : one) { into[filled++] = byte; }
    }
    return filled;
  }
  bool write(std::span<const std::uint8_t>) noexcept override { return false; }
  [[nodiscard]] long reads() const { return reads_.load(); }

 private:
  Act act_;
  std::uint8_t sequence_ = 0;
  std::atomic<long> reads_{0};
};

/// Accesses of a tick to the link; false if a sample is torn or older than the previous one.
bool tick(Receiver& receiver, std::int64_t& newest) noexcept {
  const PressureSample& latest = receiver.latest();
  bool good = latest.index >= newest;
  newest = latest.index;
  for (int n = 0; n < 16; ++n) {
    const auto sample = receiver.next();
    if (!sample) { break; }
    good = good && sample->pressure == (sample->index & 0xFF);
  }
  return good;
}

bool many_ticks(Receiver& receiver, int ticks) noexcept {
  std::int64_t newest = -1;
  bool good = true;
  for (int n = 0; n < ticks; ++n) { good = tick(receiver, newest) && good; }
  return good;
}

struct Rig {
  explicit Rig(StagedLink::Act act) : link(act), receiver(link) {
    while (link.reads() < 1) { ::usleep(1000); }  // until the reading thread has begun
  }
  StagedLink link;
  Receiver receiver;
};

constexpr std::array acts{StagedLink::Act::silent, StagedLink::Act::flood, StagedLink::Act::stall};

TEST("the filter lets computation through and stops the smallest call, beside a running thread") {
  const auto rig = [] { return std::make_unique<Rig>(StagedLink::Act::silent); };
  const Verdict quiet = check::without_system_calls(rig, [](const auto&) { return true; });
  if (quiet == Verdict::refused) { check::skip("this system refuses seccomp filters"); }
  CHECK(quiet == Verdict::silent);
  CHECK(check::without_system_calls(rig, [](const auto&) { return syscall(SYS_getpid) > 0; }) ==
        Verdict::called);
}

TEST("a tick makes no system call, whether the reader is idle, flooded or stalled") {
  for (const StagedLink::Act act : acts) {
    CHECK(check::without_system_calls([&] { return std::make_unique<Rig>(act); },
                                      [](const std::unique_ptr<Rig>& rig) {
                                        return many_ticks(rig->receiver, 100000);
                                      }) == Verdict::silent);
  }
}

TEST("a tick takes no lock and allocates nothing, and neither does the flooded reader") {
  for (const StagedLink::Act act : acts) {
    Rig rig(act);
    const long allocations = check::allocations;
    const long locks = check::locks;
    const bool good = many_ticks(rig.receiver, 100000);
    const long more_allocations = check::allocations - allocations;
    const long more_locks = check::locks - locks;
    CHECK(good);
    CHECK(more_allocations == 0);
    CHECK(more_locks == 0);
    // The queue holds 4096 frames, so an overflow proves that as many were read.
    while (act == StagedLink::Act::flood && rig.receiver.overflowed() == 0) { ::usleep(1000); }
    rig.receiver.stop();
  }
}

TEST("the counters see an allocation and a lock") {
  const long allocations = check::allocations;
  const long locks = check::locks;
  int* volatile one = new int(1);
  delete one;
  static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
  pthread_mutex_lock(&mutex);
  pthread_mutex_unlock(&mutex);
  CHECK(check::allocations > allocations);
  CHECK(check::locks == locks + 1);
}

TEST("a consumer that takes nothing costs queued samples, not the newest one") {
  Rig rig(StagedLink::Act::flood);
  while (rig.receiver.overflowed() < 1000) { ::usleep(1000); }
  rig.receiver.stop();
  std::int64_t queued = 0;
  while (rig.receiver.next()) { ++queued; }
  CHECK(queued == static_cast<std::int64_t>(Receiver::queue_capacity));
  CHECK(queued + rig.receiver.overflowed() == rig.receiver.counts().frames);
  CHECK(rig.receiver.latest().pressure == (rig.receiver.counts().frames - 1) % 256);
}

/// One frame each 1/120 s, queued while the reading thread has no processor time; in virtual time.
class LateLink final : public ByteLink {
 public:
  LateLink(int frames, int late_from, int late_until) {
    for (int n = 0; n < frames; ++n) {
      const bool late = n >= late_from && n < late_until;
      times_.push_back((late ? late_until : n + 1) / frames_per_second);
    }
  }
  [[nodiscard]] double now() const noexcept override { return time_; }
  bool wait_until(double deadline_s) noexcept override {
    time_ = next_ < times_.size() ? std::min(deadline_s, times_[next_]) : deadline_s;
    return false;
  }
  std::size_t read(std::span<std::uint8_t> into) noexcept override {
    if (next_ == times_.size() || times_[next_] > time_ || into.size() < frame_bytes) { return 0; }
    const FrameBytes one = encode({.sequence = static_cast<std::uint8_t>(next_),
                                   .pressure = static_cast<std::int16_t>(next_)});
    std::ranges::copy(one, into.begin());
    ++next_;
    return frame_bytes;
  }
  bool write(std::span<const std::uint8_t>) noexcept override { return false; }
  [[nodiscard]] bool ended() const noexcept override { return next_ == times_.size(); }

 private:
  double time_ = 0.0;
  std::size_t next_ = 0;
  std::vector<double> times_{};
};

TEST("two seconds without processor time of the reading thread are no gap") {
  LateLink link(600, 100, 340);
  Receiver receiver(link);
  while (!receiver.ended()) { ::usleep(1000); }
  std::int64_t count = 0;
  while (const auto sample = receiver.next()) {
    CHECK(sample->index == sample->pressure);
    // Rounding of sums of some seconds; a frame is through the line a period after it began.
    CHECK_NEAR(sample->arrival, double(sample->index + 1) / frames_per_second, 1e-12);
    ++count;
  }
  CHECK(count == 600);
  CHECK(receiver.counts().missing == 0);
}

TEST("a stream through a pipe arrives completely, with its gaps and its end") {
  std::array<int, 2> ends{};
  CHECK(::pipe(ends.data()) == 0);
  const Descriptor reader(ends[0]);
  DescriptorLink link(reader.number(), ends[1]);
  for (int n = 0; n < 300; ++n) {
    if (n >= 100 && n < 110) { continue; }
    CHECK(link.write(encode(
        {.sequence = static_cast<std::uint8_t>(n), .pressure = static_cast<std::int16_t>(n)})));
  }
  ::close(ends[1]);
  Receiver receiver(link);
  while (!receiver.ended()) { ::usleep(1000); }
  std::int64_t count = 0;
  std::int64_t last = -1;
  while (const auto sample = receiver.next()) {
    CHECK(sample->pressure == sample->index);
    last = sample->index;
    ++count;
  }
  CHECK(count == 290);
  CHECK(last == 299);
  CHECK(receiver.counts().missing == 10);
  CHECK(receiver.counts().gaps == 1);
}

TEST("over a terminal with bytes lost on the way every sample has its place in time") {
  std::vector<std::optional<Frame>> frames;
  for (int n = 0; n < 240; ++n) {
    frames.push_back(Frame{.pressure = static_cast<std::int16_t>(n)});
  }
  const falcon::FaultScript faults{
      .seed = 3, .faults = {{.kind = falcon::LinkFault::Kind::drop, .probability = 0.01}}};
  Transducer transducer(frames, {.faults = faults});
  PtyLink device;
  TerminalLink host(device.path());
  Receiver receiver(host);
  while (!transducer.finished()) {
    (void)device.wait_until(transducer.next_call());
    transducer.serve(device);
  }
  while (receiver.latest().pressure < 230) { ::usleep(1000); }  // frames after it may be lost
  receiver.stop();
  CHECK(transducer.faults().dropped > 5);
  CHECK(receiver.counts().missing > 5);
  std::optional<std::int64_t> first;
  std::int64_t count = 0;
  for (; const auto sample = receiver.next(); ++count) {
    if (!first) { first = sample->pressure; }
    CHECK(sample->pressure - *first == sample->index);
  }
  CHECK(count == receiver.counts().frames);
  CHECK(count > 200);
}

/// Value that is written and read completely or not at all: both halves are equal.
struct Pair {
  std::int64_t first = 0;
  std::array<std::int64_t, 7> between{};
  std::int64_t last = 0;
};

constexpr std::int64_t items = 300000;

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

}  // namespace PALPATE_FILE
