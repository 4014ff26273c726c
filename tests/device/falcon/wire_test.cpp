// SPDX-License-Identifier: MIT
// Driver and emulator in one process and in virtual time.

#include <numeric>
#include <sstream>

#include "device/byte_link.hpp"
#include "device/falcon/driver.hpp"
#include "device/falcon/emulator.hpp"
#include "tests/check.hpp"
#include "tests/device/falcon/samples.hpp"

namespace PALPATE_FILE {

using namespace palpate::device::falcon;

struct Bench {
  explicit Bench(const FirmwareOptions& firmware = {}, const FaultScript& faults = {},
                 const DriverOptions& options = {})
      : emulator(body, firmware, faults), driver(cable.host(), options) {
    cable.attach(emulator);
  }
  /// Makes one exchange per millisecond and returns the number of replies.
  int poll(int ticks, const HostPacket& request) {
    int replies = 0;
    const double begin = cable.now();
    for (int n = 1; n <= ticks; ++n) {
      if (driver.exchange(request)) { ++replies; }
      cable.run_until(begin + 1e-3 * n);
    }
    return replies;
  }

  sample::SummingBody body{};
  MemoryLink cable{};
  Emulator emulator;
  Driver driver;
};

std::vector<std::uint8_t> image_of(std::size_t bytes) {
  std::vector<std::uint8_t> image(bytes);
  std::iota(image.begin(), image.end(), std::uint8_t{17});
  return image;
}

TEST("a driver loads any image and the device then answers packets") {
  for (const std::size_t bytes : {0U, 1U, 62U, 63U, 8492U}) {
    Bench bench;
    CHECK(bench.driver.open(image_of(bytes)) == OpenResult::loaded);
    CHECK(bench.emulator.firmware().state() == FirmwareState::run);
    CHECK(bench.emulator.firmware().echoed_bytes() ==
          static_cast<std::int64_t>(bytes + 1 + packet_bytes - 1));
    CHECK(bench.poll(10, {}) == 10);
  }
}

TEST("a driver finds a device that is running, and gives up where there is none") {
  Bench bench({.loaded = true});
  CHECK(bench.driver.open(image_of(100)) == OpenResult::was_running);
  CHECK(bench.poll(10, {}) == 10);
  Bench unplugged({}, {.faults = {{.kind = LinkFault::Kind::unplug}}});
  CHECK(unplugged.driver.open(image_of(100)) == OpenResult::no_answer);
  CHECK(!unplugged.driver.exchange({}));
  CHECK(unplugged.emulator.faults_to_device().unplugged > 0);
}

TEST("a byte that is lost or changed in the echo is noticed") {
  for (const auto kind : {LinkFault::Kind::drop, LinkFault::Kind::corrupt}) {
    Bench bench(
        {}, {.faults = {
                 {.kind = kind, .direction = LinkFault::Direction::to_host, .probability = 0.01}}});
    CHECK(bench.driver.open(image_of(8492)) == OpenResult::echo_differs);
  }
}

TEST("in lock step every request of a minute at 1 kHz gets its reply") {
  Bench bench({.loaded = true});
  CHECK(bench.poll(60000, {.words = {1, 0, -1}}) == 60000);
  CHECK(bench.driver.counts().lost == 0);
  CHECK(bench.emulator.firmware().replies() == 60000);
  CHECK(bench.emulator.firmware().count(FirmwareEvent::watchdog) == 0);
}

TEST("the words of a request act on the body for the time of the watchdog") {
  for (const double watchdog : {0.020, 0.005}) {
    Bench bench({.watchdog = watchdog, .loaded = true});
    (void)bench.driver.exchange({.words = {50, 0, 0}, .homing = true});
    bench.cable.run_until(0.5);
    // One body step is the time resolution of motor words.
    CHECK_NEAR(bench.body.torque_time, watchdog, 1.001 * Emulator::body_step);
    CHECK_NEAR(bench.body.homing_time, watchdog, 1.001 * Emulator::body_step);
    CHECK_NEAR(bench.body.time, 0.5, 1.001 * Emulator::body_step);
    CHECK(bench.emulator.firmware().count(FirmwareEvent::watchdog) == 1);
  }
}

TEST("the motion of the body depends on the times of requests, not on how often it is served") {
  const auto counts_after = [](double cable_step) {
    sample::SummingBody body;
    Emulator emulator(body, {.loaded = true});
    MemoryLink cable(cable_step);
    cable.attach(emulator);
    Driver driver(cable.host());
    for (int n = 0; n < 200; ++n) {
      cable.run_until(1e-3 * n + 1e-4 * (n % 7));
      (void)driver.exchange({.words = {static_cast<std::int16_t>(n - 100), 3, 1}});
    }
    cable.run_until(0.5);
    return body.sum;
  };
  CHECK(counts_after(50e-6) == counts_after(13e-6));
  CHECK(counts_after(50e-6) == counts_after(4.9e-3));
}

TEST("with 1 % of bytes lost each exchange that was spared brings its reply") {
  Bench bench({.loaded = true},
              {.seed = 3, .faults = {{.kind = LinkFault::Kind::drop, .probability = 0.01}}},
              {.reply_deadline = 0.9e-3});
  const int replies = bench.poll(20000, {.words = {1, 2, 3}});
  // An exchange is 32 bytes; all arrive with probability 0.99^32 = 0.7250. A loss does not affect
  // the next exchange: five standard deviations of 20000 draws are 0.0158.
  CHECK_NEAR(replies / 20000.0, std::pow(0.99, 32), 0.0158);
  CHECK(bench.driver.counts().late == 0);
  const std::int64_t requests = bench.emulator.firmware().reader_counts().frames;
  CHECK(bench.emulator.firmware().replies() == requests);  // never more replies than requests
}

TEST("after an exchange that lost bytes the next one succeeds") {
  for (const auto direction : {LinkFault::Direction::to_device, LinkFault::Direction::to_host}) {
    Bench bench({.loaded = true}, {.faults = {{.kind = LinkFault::Kind::drop,
                                               .direction = direction,
                                               .probability = 0.5,
                                               .start = 0.0095,
                                               .end = 0.0105}}});
    CHECK(bench.poll(10, {}) == 10);
    CHECK(!bench.driver.exchange({}));  // at 10 ms, in the window
    CHECK(bench.poll(10, {}) == 10);
  }
}

TEST("a reply after its deadline is counted as lost and then as late") {
  Bench bench({.loaded = true},
              {.faults = {{.kind = LinkFault::Kind::latency,
                           .direction = LinkFault::Direction::to_host,
                           .end = 0.0005,
                           .latency = 0.003}}},
              {.reply_deadline = 0.001});
  CHECK(!bench.driver.exchange({}));
  bench.cable.run_until(0.010);
  CHECK(bench.driver.exchange({}));
  CHECK((bench.driver.counts() ==
         DriverCounts{.requests = 2, .replies = 1, .lost = 1, .late = 1, .superfluous = 0}));
}

TEST("power loss ends at the boot loader without torque, unplugging leaves the device running") {
  for (const auto kind : {LinkFault::Kind::power_loss, LinkFault::Kind::unplug}) {
    const bool power = kind == LinkFault::Kind::power_loss;
    Bench bench({.loaded = true}, {.faults = {{.kind = kind, .start = 0.1, .end = 0.2}}});
    CHECK(bench.poll(100, {.words = {1, 0, 0}}) == 100);
    bench.cable.run_until(power ? 0.11 : 0.101);
    CHECK(!bench.driver.exchange({.words = {1, 0, 0}}));
    if (power) { CHECK_NEAR(bench.body.torque_time, 0.1, 2.001 * Emulator::body_step); }
    bench.cable.run_until(0.15);
    CHECK((bench.emulator.firmware().words(0.15) == std::array<std::int16_t, 3>{}));
    bench.cable.run_until(power ? 0.21 : 0.2);
    CHECK(bench.body.power_losses == (power ? 1 : 0));
    CHECK(bench.emulator.firmware().state() == (power ? FirmwareState::boot : FirmwareState::run));
    if (power) { CHECK(bench.driver.open(image_of(10)) == OpenResult::loaded); }
    CHECK(bench.poll(10, {}) == 10);
  }
}

TEST("a stuck encoder keeps its count and a stuck button stays pressed, while they stick") {
  Bench bench(
      {.loaded = true},
      {.faults = {{.kind = LinkFault::Kind::stuck_encoder, .start = 0.05, .end = 0.10, .leg = 2},
                  {.kind = LinkFault::Kind::stuck_button,
                   .start = 0.05,
                   .end = 0.10,
                   .buttons = {.forward = true}}}});
  const HostPacket request{.words = {1, 1, 1}};
  for (int n = 0; n < 150; ++n) {
    const auto packet = bench.driver.exchange(request);
    const bool sticks = bench.cable.now() >= 0.05 && bench.cable.now() < 0.10;
    REQUIRE(packet.has_value());
    CHECK(packet->buttons.forward == sticks);
    CHECK(packet->counts[0] == packet->counts[2]);
    CHECK(
        (sticks ? packet->counts[1] <= packet->counts[0] : packet->counts[1] == packet->counts[0]));
    if (n == 99) { CHECK(packet->counts[1] < packet->counts[0] - 900); }  // 20 steps a tick
    bench.cable.run_until(1e-3 * (n + 1));
  }
}

/// Session with pauses longer than the watchdog time, lost bytes and a stuck encoder.
const FaultScript faults{.seed = 11,
                         .faults = {{.kind = LinkFault::Kind::drop, .probability = 0.01},
                                    {.kind = LinkFault::Kind::stuck_encoder, .start = 0.2}}};

/// Replay of the requests that arrived. Link faults are not repeated, device faults are.
FaultScript device_faults_only() {
  FaultScript script = faults;
  script.faults.erase(script.faults.begin());
  return script;
}

WireRecording session(std::size_t most_records = 4000) {
  sample::SummingBody body;
  Emulator emulator(body, {.loaded = true}, faults);
  WireRecording recording(most_records);
  emulator.observe(&recording);
  MemoryLink cable;
  cable.attach(emulator);
  Driver driver(cable.host(), {.reply_deadline = 0.7e-3});
  double time = 0.0;
  for (int n = 0; n < 1000; ++n) {
    time += 1e-3 + (n % 100 == 99 ? 0.05 : 1.3e-5 * (n % 11));
    cable.run_until(time);
    const auto word = static_cast<std::int16_t>(37 * n);
    (void)driver.exchange({.words = {word, static_cast<std::int16_t>(-word), 5}});
  }
  return recording;
}

/// Plays a recording on a new device with the faults of the session.
ReplayResult played(const WireRecording& recording, double watchdog = FirmwareOptions{}.watchdog) {
  sample::SummingBody body;
  Emulator emulator(body, {.watchdog = watchdog, .loaded = true}, device_faults_only());
  return replay(recording, emulator);
}

TEST("a session played again, also from its text, gives the same replies bit for bit") {
  const WireRecording recording = session();
  CHECK(recording.records().size() > 1500);
  CHECK(recording.records().size() < 2000);  // 1 % of bytes were lost: not every request arrived
  CHECK(played(recording).requests == static_cast<std::int64_t>(recording.records().size() / 2));
  CHECK(played(recording).different_replies == 0);
  std::stringstream text;
  write_csv(text, recording);
  const WireRecording again = read_csv(text);
  CHECK(again.records() == recording.records());
  CHECK(played(again).different_replies == 0);
}

TEST("a replay notices a body that differs, if only by a watchdog of another length") {
  CHECK(played(session(), 0.021).different_replies > 0);
}

TEST("records that do not fit are counted") {
  const WireRecording recording = session(100);
  CHECK(recording.records().size() == 100);
  CHECK(recording.left_out() > 0);
}

TEST("a text that is not a recording is refused with its line") {
  const auto refused = [](const std::string& rows) {
    std::istringstream text("time_s,direction,bytes\n" + rows);
    return read_csv(text);
  };
  const std::string good = "0.5,to-device,3c41414141414141414141414141413e\n";
  CHECK(refused(good).records().size() == 1);
  CHECK_THROWS(refused("x,to-device,3c\n"), "line 2: time_s");
  CHECK_THROWS(refused(good + "1,sideways,3c\n"), "line 3: direction");
  CHECK_THROWS(refused(good + "1,to-host\n"), "line 3: bytes");
  CHECK_THROWS(refused("1,to-host,3c41\n"), "line 2: bytes");
  CHECK_THROWS(refused("1,to-host,3c414141414141414141414141413e41\n"), "line 2: bytes");
  CHECK_THROWS(refused(good + "0.4" + good.substr(3)), "line 3: time_s goes back");
  CHECK_THROWS(refused("nan" + good.substr(3)), "line 2: time_s");
  std::istringstream headless("0.5,to-device\n");
  CHECK_THROWS(read_csv(headless), "line 1: header");
}

}  // namespace PALPATE_FILE
