// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

#include "device/falcon/packet.hpp"

namespace palpate::device::falcon {

/// What the firmware reads and drives: mechanism, motors, encoders, buttons, and the hand on them.
class Body {
 public:
  Body() = default;
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;
  virtual ~Body() = default;

  /// Moves on by `duration_s` with these motor words, as received, and homing on or off.
  virtual void advance(double duration_s, const std::array<std::int16_t, 3>& words,
                       bool homing) noexcept = 0;
  /// Counters, buttons and homed legs as they are now.
  [[nodiscard]] virtual DevicePacket present() const noexcept = 0;
  /// Power went: whatever the electronics remembers is gone, homing above all.
  virtual void lose_power() noexcept {}
};

}  // namespace palpate::device::falcon
