// SPDX-License-Identifier: MIT
#include "device/falcon/plant_body.hpp"

#include "device/falcon/emulated_falcon.hpp"
#include "tests/check.hpp"

using namespace palpate::device;
using namespace palpate::device::falcon;

namespace {

Hand resting_hand() {
  Hand hand;
  hand.intent = Intent();
  return hand;
}

}  // namespace

TEST("the person homes the device when the host asks, and only then") {
  PlantBody body({.homed = false, .homes = true, .seed = 3}, resting_hand());
  const auto homed = [&] {
    const DevicePacket packet = body.present();
    return packet.homed[0] && packet.homed[1] && packet.homed[2];
  };
  for (int step = 0; step < 20000; ++step) { body.advance(50e-6, {}, false); }
  CHECK(!homed());
  for (int step = 0; step < 50000; ++step) { body.advance(50e-6, {}, true); }
  CHECK(homed());
  const Kinematics kinematics;
  const auto angles = kinematics.inverse(body.plant().position());
  CHECK(angles && body.present().counts == counts_of_angles(kinematics.geometry(), angles->theta1));
  body.lose_power();
  CHECK(!homed());
}

TEST("a word pulls the grip in, and the delivered force says so") {
  PlantBody body({}, resting_hand());
  const double before = body.plant().position().z();
  for (int step = 0; step < 20000; ++step) { body.advance(50e-6, {500, 500, 500}, false); }
  CHECK(body.plant().position().z() < before - 1e-3);
  CHECK(body.delivered_force().z() < -1.0);
}

TEST("what is asked for in newtons is what the hand gets") {
  EmulatedFalcon device({}, resting_hand());
  const Eigen::Vector3d force(0.5, -0.3, -1.2);
  double time = 0.0;
  for (int tick = 0; tick < 2000; ++tick) {
    device.exchange(force);
    device.run_until(time += 1e-3);
  }
  // A word is 0.0026 N of each motor at the centre; a count moves the pose by 0.05 mm.
  CHECK_NEAR(device.body().delivered_force(), force, 0.012);
  CHECK(!device.saturated());
  CHECK(device.counts().replies == 2000);
}

TEST("past the wire nothing is rounded, and two runs are the same to the bit") {
  Eigen::Vector3d ends[2];
  for (Eigen::Vector3d& end : ends) {
    EmulatedFalcon device({.wire = false}, resting_hand());
    for (int tick = 1; tick <= 500; ++tick) {
      const DeviceSample sample = device.exchange({0.1, 0.0, -0.4});
      CHECK(sample.position == device.body().plant().position());
      device.run_until(1e-3 * tick);
    }
    end = device.body().plant().position();
  }
  CHECK(ends[0] == ends[1]);
}

TEST("a start beyond reach is refused") {
  CHECK_THROWS(PlantBody({.start = {0.0, 0.0, 0.3}}, resting_hand()), "reach");
}
