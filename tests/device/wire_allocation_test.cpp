// SPDX-License-Identifier: MIT
// One process, both ends: readers, firmware, faults, emulator, driver and recording.
#include "device/falcon/driver.hpp"
#include "device/falcon/wire_recording.hpp"
#include "tests/check.hpp"
#include "tests/device/falcon_samples.hpp"
#include "tests/model/allocation_count.hpp"

namespace {

using namespace palpate::device::falcon;

TEST("upload and exchanges with faults on the line allocate nothing") {
  const FaultScript script{
      .seed = 2,
      .faults = {{.kind = LinkFault::Kind::drop, .probability = 0.002, .start = 0.5},
                 {.kind = LinkFault::Kind::duplicate, .probability = 0.002, .start = 0.5},
                 {.kind = LinkFault::Kind::corrupt, .probability = 0.002, .start = 0.5},
                 {.kind = LinkFault::Kind::latency, .latency = 1e-4, .jitter = 1e-4},
                 {.kind = LinkFault::Kind::stuck_encoder, .start = 1.0},
                 {.kind = LinkFault::Kind::power_loss, .start = 3.0, .end = 3.1}}};
  const std::vector<std::uint8_t> image(8492, 0x5A);
  sample::SummingBody body;
  Emulator emulator(body, {}, script);
  WireRecording recording(100000);
  emulator.observe(&recording);
  MemoryLink cable;
  cable.attach(emulator);
  Driver driver(cable.host());
  const long before = check::allocations;
  const OpenResult opened = driver.open(image);
  for (int n = 0; n < 4000; ++n) {
    (void)driver.exchange({.words = {1, 2, 3}});
    cable.run_until(cable.now() + 1e-3);
  }
  const long after = check::allocations;
  CHECK(after == before);
  CHECK(opened == OpenResult::loaded);
  CHECK(driver.counts().replies > 2000);
  CHECK(driver.counts().lost > 0);
  CHECK(emulator.firmware().count(FirmwareEvent::power_loss) == 1);
}

TEST("the counter sees an allocation") {
  const long before = check::allocations;
  int* volatile one = new int(1);
  delete one;
  CHECK(check::allocations > before);
}

}  // namespace
