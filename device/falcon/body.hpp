// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "device/falcon/packet.hpp"

namespace palpate::device::falcon {

/// Interface of the hardware that the firmware reads and drives: mechanism, motors, encoders and
/// buttons, with the hand on the grip.
class Body {
 public:
  Body() = default;
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;
  virtual ~Body() = default;

  /// Advances by `duration_s` [s] with the motor words as received and with homing on or off.
  virtual void advance(double duration_s, const std::array<std::int16_t, 3>& words,
                       bool homing) noexcept = 0;
  /// Returns the present counts, buttons and homed legs.
  [[nodiscard]] virtual DevicePacket present() const noexcept = 0;
  /// Simulates a loss of power: all state of the electronics is reset, including homing.
  virtual void lose_power() noexcept {}
};

// Body without mechanics: counts and buttons follow a script and do not depend on the motors.

struct GripScript {
  /// Counts of the three legs at one time, relative to their index marks.
  struct Pose {
    double time = 0.0;  ///< [s]
    std::array<int, 3> counts{};
  };
  /// Interval [start, end) in which buttons are pressed [s].
  struct Press {
    Buttons buttons{};
    double start = 0.0;
    double end = 0.0;
  };
  std::vector<Pose> poses{};  ///< ascending time; interpolated linearly, constant outside
  std::vector<Press> presses{};
  std::array<int, 3> power_on{};  ///< offset added to the scripted counts before homing
  bool homed = true;              ///< initial state
};

/// Scripted body with homing. A leg that is not homed reports its count plus an offset. While
/// homing is on, a leg is armed beyond an arm angle of 60 degrees (count 686 in libnifalcon's
/// geometry). It is homed when it returns inward through count 0, the index mark at 35 degrees. The
/// position of the mark is inferred from the users' procedure; it is not documented.
class ScriptedGrip final : public Body {
 public:
  explicit ScriptedGrip(GripScript script);

  void advance(double duration_s, const std::array<std::int16_t, 3>& words,
               bool homing) noexcept override;
  [[nodiscard]] DevicePacket present() const noexcept override;
  void lose_power() noexcept override;

 private:
  [[nodiscard]] int count(std::size_t leg) const noexcept;

  GripScript script_;
  double time_ = 0.0;
  std::size_t segment_ = 0;  ///< index of the last pose reached
  std::array<bool, 3> armed_{};
  std::array<bool, 3> homed_{};
};

}  // namespace palpate::device::falcon
