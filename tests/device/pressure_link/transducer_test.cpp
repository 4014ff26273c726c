// SPDX-License-Identifier: MIT

#include "device/pressure_link/transducer.hpp"

#include <thread>

#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate::device;
using namespace palpate::device::pressure_link;
using Frames = std::vector<std::optional<Frame>>;
using Kind = falcon::LinkFault::Kind;

struct Heard {
  std::vector<std::uint8_t> bytes{};
  std::vector<double> times{};  ///< when each byte came [s]
};

/// Receiving end of the link, in virtual time.
class Ear final : public ByteLink {
 public:
  double time = 0.0;
  Heard heard{};

  [[nodiscard]] double now() const noexcept override { return time; }
  std::size_t read(std::span<std::uint8_t>) noexcept override { return 0; }
  bool wait_until(double deadline_s) noexcept override {
    time = deadline_s;
    return false;
  }
  bool write(std::span<const std::uint8_t> some) noexcept override {
    heard.bytes.insert(heard.bytes.end(), some.begin(), some.end());
    heard.times.insert(heard.times.end(), some.size(), time);
    return true;
  }
};

Frames ramp(int count) {
  Frames frames;
  for (int n = 0; n < count; ++n) {
    frames.push_back(Frame{.pressure = static_cast<std::int16_t>(n)});
  }
  return frames;
}

/// Reads all bytes, each at its own time.
Heard listen(Transducer& transducer) {
  Ear ear;
  ear.time = 5.0;  // the line was there before
  while (!transducer.finished()) {
    transducer.serve(ear);
    ear.time = std::fmax(ear.time, transducer.next_call());
    if (!std::isfinite(ear.time)) { break; }
  }
  return ear.heard;
}

ReaderCounts counts_of(const std::vector<std::uint8_t>& bytes) {
  FrameReader reader;
  for (const std::uint8_t byte : bytes) { (void)reader.take(byte); }
  return reader.counts();
}

TEST("bytes come at 960 a second, frames at 120") {
  Transducer transducer(ramp(240));
  const Heard ear = listen(transducer);
  CHECK(ear.bytes.size() == 240 * 8);
  CHECK(counts_of(ear.bytes).frames == 240);
  for (std::size_t n = 0; n < ear.times.size(); ++n) {
    CHECK_NEAR(ear.times[n], 5.0 + double(n + 1) / 960.0, 1e-12);  // rounding of sums near 7 s
  }
  CHECK(transducer.frames_sent() == 240);
  CHECK(transducer.lost_writes() == 0);
}

TEST("the bytes sent do not depend on how often they are read") {
  const falcon::FaultScript faults{.seed = 4,
                                   .faults = {{.kind = Kind::drop, .probability = 0.02},
                                              {.kind = Kind::corrupt, .probability = 0.02}}};
  Transducer often(ramp(500), {.faults = faults});
  Transducer seldom(ramp(500), {.faults = faults});
  const Heard all = listen(often);
  Ear ear;
  for (ear.time = 0.0; !seldom.finished(); ear.time += 0.7) { seldom.serve(ear); }
  CHECK(all.bytes == ear.heard.bytes);
  CHECK(often.faults() == seldom.faults());
  CHECK(often.faults().dropped > 0);
  CHECK(often.faults().corrupted > 0);
}

TEST("a missing frame leaves the line silent and its sequence number unused") {
  Frames frames = ramp(10);
  frames[4].reset();
  Transducer transducer(frames);
  const Heard ear = listen(transducer);
  CHECK(ear.bytes.size() == 9 * 8);
  CHECK_NEAR(ear.times[4 * 8] - ear.times[4 * 8 - 1], 9.0 / 960.0, 1e-12);
  CHECK(counts_of(ear.bytes).missing == 1);
  CHECK(counts_of(ear.bytes).gaps == 1);
}

TEST("one that repeats goes on without a pause and without a jump of sequence numbers") {
  Transducer transducer(ramp(100), {.battery_low = true, .repeats = true});
  Ear ear;
  for (ear.time = 0.0; ear.time < 10.0; ear.time += 0.01) { transducer.serve(ear); }
  const ReaderCounts counts = counts_of(ear.heard.bytes);
  CHECK(counts.missing == 0);
  CHECK(counts.bad_frames == 0);
  CHECK(counts.frames >= 1198);  // 9.99 s of 120 a second
  CHECK(counts.battery_low == counts.frames);
  CHECK(!transducer.finished());
}

TEST("a burst takes bytes in a row, and a reader loses the frames that it touched and no more") {
  // Begins at 1 of 2000 bytes and takes 20: at most four frames each.
  const falcon::FaultScript faults{
      .seed = 9, .faults = {{.kind = Kind::corrupt, .probability = 0.0005, .run = 20}}};
  constexpr int frames = 5000;
  Transducer transducer(ramp(frames), {.faults = faults});
  const Heard ear = listen(transducer);
  Transducer unhurt(ramp(frames));
  const Heard clean = listen(unhurt);
  REQUIRE(ear.bytes.size() == clean.bytes.size());
  std::vector<char> touched(frames, 0);
  std::int64_t changed = 0;
  for (std::size_t n = 0, run = 0; n < ear.bytes.size(); ++n) {
    const bool hit = ear.bytes[n] != clean.bytes[n];
    if (!hit && run > 0) { CHECK(run >= 20); }
    run = hit ? run + 1 : 0;
    if (!hit) { continue; }
    touched[n / 8] = 1;
    ++changed;
  }
  CHECK(changed == transducer.faults().corrupted);
  CHECK(changed >= 5 * 20);
  CHECK(counts_of(ear.bytes).frames == frames - std::count(touched.begin(), touched.end(), 1));
}

TEST("over a pseudo-terminal in wall-clock time, samples come at the line's pace") {
  PtyLink device;
  TerminalLink host(device.path());
  Transducer transducer(ramp(60));
  const double begin = host.now();
  std::thread service([&] {
    while (!transducer.finished()) {
      (void)device.wait_until(transducer.next_call());
      transducer.serve(device);
    }
  });
  FrameReader reader;
  std::array<std::uint8_t, 64> buffer{};
  // The machine may be busy: the deadline only decides how long a failure takes.
  while (reader.counts().frames < 60 && host.wait_until(begin + 20.0)) {
    const std::size_t count = host.read(buffer);
    for (std::size_t n = 0; n < count; ++n) { (void)reader.take(buffer[n]); }
  }
  const double elapsed = host.now() - begin;
  service.join();
  CHECK(reader.counts().frames == 60);
  CHECK(reader.counts().bad_frames == 0);
  CHECK(elapsed >= 60.0 / 120.0 - 1.0 / 960.0);  // never faster than the line
}

}  // namespace PALPATE_FILE
