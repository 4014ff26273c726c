// SPDX-License-Identifier: MIT

#include "device/falcon/driver.hpp"
#include "device/falcon/emulator.hpp"
#include "device/falcon/plant.hpp"
#include "tests/allocation_count.hpp"
#include "tests/check.hpp"
#include "tests/device/falcon/samples.hpp"

namespace PALPATE_FILE {

using namespace palpate::device;
using namespace palpate::device::falcon;
using Vector = Eigen::Vector3d;

TEST("kinematics allocate nothing, whether they succeed or not") {
  const Kinematics kinematics;
  const long before = check::allocations;
  for (int n = 0; n < 100; ++n) {
    const auto angles = kinematics.inverse({0.0, 1e-4 * n, 0.12});
    const auto back = kinematics.forward(angles->theta1);
    CHECK(back.has_value());
    CHECK(!kinematics.inverse({0.0, 0.0, 0.4}));
    CHECK(!kinematics.forward({-2.0, 2.0, 0.5}));
  }
  CHECK(check::allocations == before);
  int* volatile one = new int(1);  // the counter sees an allocation
  delete one;
  CHECK(check::allocations == before + 1);
}

TEST("a tick of drivers, encoders, motors, plant, arm, intent and its stop allocates nothing") {
  const Vector start = Kinematics::centre();
  Plant plant;
  Motors motors;
  Encoders encoders(libnifalcon(), {}, 1);
  DriverProfile correct(DriverProfile::Kind::correct);
  DriverProfile stock(DriverProfile::Kind::stock);
  Hand hand{.arm = arm_stage,
            .intent = Intent({.actions = {Intermittent{}, Withdraw{}}, .tremor = 5e-5})};
  plant.place(start, hand);
  encoders.home();
  const long before = check::allocations;
  for (int n = 0; n < 1500; ++n) {
    encoders.sample(plant.theta1(), false);
    const Vector seen = correct.position(encoders.counts());
    stock.position(encoders.counts());
    const Vector force(0.0, 0.0, n > 700 ? 9.0 : std::sin(0.1 * n));
    motors.command((n % 2 == 0 ? correct.words(seen, force) : stock.words(seen, force)).sent);
    plant.advance(1e-3, motors, hand);
    if (n == 400) { hand.intent.loss_of_resistance(plant.time()); }
    (void)plant.energy(hand);
  }
  CHECK(check::allocations == before);
}

// One process with both ends: readers, firmware, faults, emulator, driver and recording.

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

}  // namespace PALPATE_FILE
