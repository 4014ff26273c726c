// SPDX-License-Identifier: MIT
#include "device/falcon/wire_recording.hpp"

#include <sstream>

#include "device/falcon/driver.hpp"
#include "tests/check.hpp"
#include "tests/device/falcon_samples.hpp"

namespace {

using namespace palpate::device::falcon;

/// A session with pauses longer than the watchdog, lost bytes and a stuck encoder.
const FaultScript faults{.seed = 11,
                         .faults = {{.kind = LinkFault::Kind::drop, .probability = 0.01},
                                    {.kind = LinkFault::Kind::stuck_encoder, .start = 0.2}}};

/// The replay gets the requests that arrived: the link's own faults are over, the device's not.
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

TEST("a session played again gives the same replies bit for bit") {
  const WireRecording recording = session();
  CHECK(recording.records().size() > 1500);
  CHECK(recording.records().size() < 2000);  // 1 % of bytes were lost: not every request arrived
  sample::SummingBody body;
  Emulator emulator(body, {.loaded = true}, device_faults_only());
  const ReplayResult result = replay(recording, emulator);
  CHECK(result.requests == static_cast<std::int64_t>(recording.records().size() / 2));
  CHECK(result.different_replies == 0);
}

TEST("a replay notices a body that differs, if only by a watchdog of another length") {
  const WireRecording recording = session();
  sample::SummingBody body;
  Emulator emulator(body, {.watchdog = 0.021, .loaded = true}, device_faults_only());
  CHECK(replay(recording, emulator).different_replies > 0);
}

TEST("the text form reads back the same, times and bytes, and plays the same") {
  const WireRecording recording = session();
  std::stringstream text;
  write_csv(text, recording);
  const WireRecording again = read_csv(text);
  CHECK(again.records() == recording.records());
  sample::SummingBody body;
  Emulator emulator(body, {.loaded = true}, device_faults_only());
  CHECK(replay(again, emulator).different_replies == 0);
}

TEST("what does not fit is counted") {
  const WireRecording recording = session(100);
  CHECK(recording.records().size() == 100);
  CHECK(recording.left_out() > 0);
}

TEST("a text that is no recording is refused with its line") {
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

}  // namespace
