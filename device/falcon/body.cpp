// SPDX-License-Identifier: MIT

#include "device/falcon/body.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::device::falcon {
namespace {

constexpr int arming_count = 686;  // (60 - 35) degrees at 27.446 counts per degree

}  // namespace

ScriptedGrip::ScriptedGrip(GripScript script) : script_(std::move(script)) {
  if (script_.poses.empty()) { script_.poses.emplace_back(); }
  homed_.fill(script_.homed);
}

int ScriptedGrip::count(std::size_t leg) const noexcept {
  const GripScript::Pose& from = script_.poses[segment_];
  if (segment_ + 1 == script_.poses.size() || time_ <= from.time) { return from.counts[leg]; }
  const GripScript::Pose& to = script_.poses[segment_ + 1];
  const double share = (time_ - from.time) / (to.time - from.time);
  return static_cast<int>(std::lround(std::lerp(from.counts[leg], to.counts[leg], share)));
}

void ScriptedGrip::advance(double duration_s, const std::array<std::int16_t, 3>& /*words*/,
                           bool homing) noexcept {
  time_ += duration_s;
  while (segment_ + 1 < script_.poses.size() && script_.poses[segment_ + 1].time <= time_) {
    ++segment_;
  }
  for (std::size_t leg = 0; leg < homed_.size(); ++leg) {
    if (!homing) {
      armed_[leg] = false;
      continue;
    }
    const int now = count(leg);
    armed_[leg] = armed_[leg] || now >= arming_count;
    homed_[leg] = homed_[leg] || (armed_[leg] && now <= 0);
  }
}

DevicePacket ScriptedGrip::present() const noexcept {
  DevicePacket packet{.homed = homed_};
  for (std::size_t leg = 0; leg < homed_.size(); ++leg) {
    const int shown = count(leg) + (homed_[leg] ? 0 : script_.power_on[leg]);
    packet.counts[leg] = static_cast<std::int16_t>(shown);  // wraps at 16 bits, as the counter does
  }
  for (const GripScript::Press& press : script_.presses) {
    if (time_ < press.start || time_ >= press.end) { continue; }
    packet.buttons = packet.buttons | press.buttons;
  }
  return packet;
}

void ScriptedGrip::lose_power() noexcept {
  armed_.fill(false);
  homed_.fill(false);
}

}  // namespace palpate::device::falcon
