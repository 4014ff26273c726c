// SPDX-License-Identifier: MIT
#include "device/servo_loop.hpp"

#include "tests/check.hpp"

using namespace palpate::device;
using Eigen::Vector3d;

namespace {

/// Its place is the number of the tick; it notes what it is asked for.
class Counter final : public HapticDevice {
 public:
  DeviceSample exchange(const Vector3d& force) noexcept override {
    ++exchanges;
    acting = force.x();
    return {.position = {place, 0.0, 0.0}};
  }
  double place = 0.0;
  double acting = 0.0;
  int exchanges = 0;
};

Vector3d mirror(const DeviceSample& sample) { return {-sample.position.x(), 0.0, 0.0}; }

}  // namespace

TEST("a force acts exactly as many ticks late as it is told to") {
  for (const int delay : {0, 1, 2, 5}) {
    Counter device;
    ServoLoop loop(device, delay);
    for (int tick = 0; tick < 20; ++tick) {
      device.place = tick;
      loop.tick(mirror);
      const double expected = tick >= delay ? -(tick - delay) : 0.0;
      CHECK(device.acting == expected);
      CHECK(loop.sent().x() == expected);
    }
    CHECK(device.exchanges == (delay == 0 ? 40 : 20));
  }
}

TEST("the sample of a tick is that of its first exchange") {
  Counter device;
  ServoLoop loop(device, 0);
  device.place = 3.0;
  CHECK(loop.tick(mirror).position.x() == 3.0);
}
