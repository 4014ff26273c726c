// SPDX-License-Identifier: MIT

#include "device/falcon/emulated_falcon.hpp"

#include <algorithm>

namespace palpate::device::falcon {

EmulatedFalcon::EmulatedFalcon(const EmulatedFalconOptions& options, const Hand& hand)
    : options_(options),
      kinematics_(options.body.geometry),
      body_(options.body, hand),
      emulator_(body_, FirmwareOptions{.loaded = true}, options.faults),
      driver_(link_.host(), {.reply_deadline = 0.0, .keep_late = true}),
      profile_(options.stock_profile ? DriverProfile::Kind::stock : DriverProfile::Kind::correct,
               kinematics_, options.body.motors),
      place_(options.body.start) {
  link_.attach(emulator_);
}

DeviceSample EmulatedFalcon::exchange(const Eigen::Vector3d& force) noexcept {
  if (options_.wire) { return exchange_packets(force); }
  const Eigen::Vector3d place = body_.plant().position();
  if (const auto legs = kinematics_.legs(place)) {
    torque_ = torque_of_force(jacobian(*legs), force);
  }
  return {.position = place};
}

DeviceSample EmulatedFalcon::exchange_packets(const Eigen::Vector3d& force) noexcept {
  const Command command = profile_.words(place_, force);
  saturated_ = command.saturated;
  const std::optional<DevicePacket> reply = driver_.exchange({.words = command.sent});
  if (!reply) { return {.position = place_, .answered = false, .homed = homed_}; }
  homed_ = std::ranges::all_of(reply->homed, [](bool leg) { return leg; });
  if (homed_) { place_ = profile_.position(reply->counts); }  // counts are not valid before
  return {.position = place_, .homed = homed_};
}

void EmulatedFalcon::run_until(double time) noexcept {
  if (options_.wire) {
    link_.run_until(time);
  } else {
    body_.advance_exactly(time - body_.plant().time(), torque_);
  }
}

}  // namespace palpate::device::falcon
