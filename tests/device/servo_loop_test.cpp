// SPDX-License-Identifier: MIT

#include "device/servo_loop.hpp"

#include "tests/check.hpp"

using namespace palpate::device;
using Eigen::Vector3d;

namespace PALPATE_FILE {

/// Device whose position is the tick number, and half a unit more at the next exchange; it records
/// the commanded forces.
class Counter final : public HapticDevice {
 public:
  DeviceSample exchange(const Vector3d& force) noexcept override {
    ++exchanges;
    acting = force.x();
    const double now = place;
    place += 0.5;
    return {.position = {now, 0.0, 0.0}};
  }
  double place = 0.0;
  double acting = 0.0;
  int exchanges = 0;
};

Vector3d mirror(const DeviceSample& sample) { return {-sample.position.x(), 0.0, 0.0}; }

TEST("a force acts exactly as many ticks late as the delay") {
  for (const int delay : {0, 1, 2, 5}) {
    Counter device;
    ServoLoop loop(device, delay);
    for (int tick = 0; tick < 20; ++tick) {
      device.place = tick;
      CHECK(loop.tick(mirror).position.x() == tick);  // of the first exchange
      const double expected = tick >= delay ? -(tick - delay) : 0.0;
      CHECK(device.acting == expected);
      CHECK(loop.sent().x() == expected);
    }
    CHECK(device.exchanges == (delay == 0 ? 40 : 20));
  }
}

TEST("a spring felt without delay gives back what it took, and a little more") {
  // Sampled force of a spring on loading and unloading: the hand gains k d^2 / 2 for each step d in
  // each direction.
  PassivityObserver observer;
  const double k = 800.0;
  const double step = 1e-4;
  double place = 0.0;
  double time = 0.0;
  for (int tick = 0; tick < 200; ++tick) {
    const Vector3d force(-k * place, 0.0, 0.0);
    place += tick < 100 ? step : -step;
    time += 1e-3;
    if (tick == 0) { observer.observe(0.0, {0.0, 0.0, 0.0}, force); }
    observer.observe(time, {place, 0.0, 0.0}, force);
  }
  CHECK_NEAR(observer.energy(), -200.0 * 0.5 * k * step * step, 1e-15);
  CHECK_NEAR(observer.least(), observer.energy(), 0.0);
  CHECK_NEAR(observer.least_at(), time, 1e-12);
}

TEST("a damper takes energy only") {
  PassivityObserver observer;
  const double b = 3.0;
  double last = 0.0;
  Vector3d force = Vector3d::Zero();
  for (int tick = 0; tick < 1000; ++tick) {
    const double place = 0.01 * std::sin(0.02 * tick);
    observer.observe(1e-3 * tick, {place, 0.0, 0.0}, force);
    force.x() = -b * (place - last) / 1e-3;
    last = place;
  }
  CHECK(observer.energy() > 0.0);
}

TEST("the controller takes back what is missing, within its limit") {
  PassivityController controller(1e-3, 50.0);
  const Vector3d velocity(0.1, 0.0, 0.0);
  const Vector3d force(1.0, 2.0, 0.0);
  CHECK(controller.limit(1e-6, velocity, force) == force);
  const Vector3d limited = controller.limit(-1e-4, velocity, force);
  // Damping force times velocity over one period is the shortage.
  CHECK_NEAR((force - limited).dot(velocity) * 1e-3, 1e-4, 1e-18);
  CHECK_NEAR(controller.taken(), 1e-4, 1e-18);
  const Vector3d most = controller.limit(-1.0, velocity, force);
  CHECK_NEAR((force - most).norm(), 50.0 * 0.1, 1e-12);
  CHECK(controller.limit(-1.0, Vector3d::Zero(), force) == force);
}

}  // namespace PALPATE_FILE
