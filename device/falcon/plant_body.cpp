// SPDX-License-Identifier: MIT
#include "device/falcon/plant_body.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace palpate::device::falcon {

namespace {

/// Out until every arm is beyond its arming angle, in past the index marks, and back.
Intent homing_gesture(const Eigen::Vector3d& start) {
  constexpr double out = 0.174;  // z [m]: theta1 is 72 degrees on the axis
  constexpr double in = 0.105;   // 12 degrees
  constexpr double speed = 0.15;
  constexpr double ramp = 0.1;
  IntentScript script{.start = start};
  const double outmost = std::max(out, start.z());
  if (outmost > start.z()) {
    script.actions.emplace_back(
        Withdraw{.distance = outmost - start.z(), .speed = speed, .ramp = ramp});
  }
  script.actions.emplace_back(Hold{.duration = 0.2});
  script.actions.emplace_back(Advance{.distance = outmost - in, .speed = speed, .ramp = ramp});
  script.actions.emplace_back(Hold{.duration = 0.2});
  if (start.z() > in) {
    script.actions.emplace_back(Withdraw{.distance = start.z() - in, .speed = speed, .ramp = ramp});
  }
  return Intent(script);
}

}  // namespace

PlantBody::PlantBody(const PlantBodyOptions& options, const Hand& hand)
    : options_(options),
      kinematics_(options.geometry),
      hand_(hand),
      gesture_(homing_gesture(options.start)),
      plant_(kinematics_, options.plant),
      motors_(options.motors),
      encoders_(options.geometry, options.encoders, options.seed) {
  if (!plant_.place(options.start, hand_)) {
    throw std::invalid_argument("the grip's start is beyond the device's reach");
  }
  if (options.homed) { encoders_.home(); }
  encoders_.sample(plant_.theta1(), false);
}

void PlantBody::advance(double duration_s, const std::array<std::int16_t, 3>& words,
                        bool homing) noexcept {
  if (homing && options_.homes && !gestured_ && !encoders_.all_homed()) { begin_gesture(); }
  motors_.command(words);
  plant_.advance(duration_s, motors_, hand_);
  encoders_.sample(plant_.theta1(), homing);
}

void PlantBody::advance_exactly(double duration_s, const Eigen::Vector3d& torque) noexcept {
  motors_.command_torque(torque);
  plant_.advance(duration_s, motors_, hand_);
  encoders_.sample(plant_.theta1(), false);
}

void PlantBody::begin_gesture() noexcept {
  gesture_.delay(plant_.time());
  std::swap(hand_.intent, gesture_);
  gestured_ = true;
}

DevicePacket PlantBody::present() const noexcept {
  return {.counts = encoders_.counts(), .homed = encoders_.homed()};
}

/// The counters begin anywhere again: a new device with the grip where it is.
void PlantBody::lose_power() noexcept {
  encoders_ = Encoders(options_.geometry, options_.encoders, ++options_.seed);
  encoders_.sample(plant_.theta1(), false);
  gestured_ = false;
}

Eigen::Vector3d PlantBody::delivered_force() const noexcept {
  const auto legs = kinematics_.legs(plant_.position());
  if (!legs) { return Eigen::Vector3d::Zero(); }
  return force_of_torque(jacobian(*legs), motors_.torque_after(0.0));
}

}  // namespace palpate::device::falcon
