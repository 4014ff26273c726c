// SPDX-License-Identifier: MIT
#pragma once
/// Test doubles for the firmware: a sink that records its output, and a body that records its
/// commands.

#include <vector>

#include "device/falcon/body.hpp"
#include "device/falcon/emulator.hpp"

namespace sample {

using namespace palpate::device::falcon;

/// Records all output of a firmware.
class Kept final : public FirmwareSink {
 public:
  void send(std::span<const std::uint8_t> bytes) noexcept override {
    sent.insert(sent.end(), bytes.begin(), bytes.end());
  }
  void served(const HostPacket& request, const DevicePacket&) noexcept override {
    requests.push_back(request);
  }
  void happened(FirmwareEvent event) noexcept override { events.push_back(event); }

  std::vector<std::uint8_t> sent{};
  std::vector<HostPacket> requests{};
  std::vector<FirmwareEvent> events{};
};

/// Body whose legs move one count per body step and motor word. Its state depends on every word and
/// on the duration of each word.
class SummingBody final : public Body {
 public:
  void advance(double duration_s, const std::array<std::int16_t, 3>& words,
               bool homing) noexcept override {
    time += duration_s;
    for (std::size_t leg = 0; leg < sum.size(); ++leg) { sum[leg] += words[leg]; }
    torque_time += words[0] != 0 ? duration_s : 0.0;
    homing_time += homing ? duration_s : 0.0;
  }
  [[nodiscard]] DevicePacket present() const noexcept override {
    DevicePacket packet;
    for (std::size_t leg = 0; leg < sum.size(); ++leg) {
      packet.counts[leg] = static_cast<std::int16_t>(sum[leg]);
    }
    return packet;
  }
  void lose_power() noexcept override { ++power_losses; }

  double time = 0.0;
  double torque_time = 0.0;
  double homing_time = 0.0;
  int power_losses = 0;
  std::array<std::int64_t, 3> sum{};
};

}  // namespace sample
