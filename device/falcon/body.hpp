// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <vector>

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

// A body without mechanics: counts and buttons follow a script, whatever the motors do.

struct GripScript {
  /// Counts of the three legs at a time, seen from their index marks.
  struct Pose {
    double time = 0.0;  ///< [s]
    std::array<int, 3> counts{};
  };
  /// Buttons held during [start, end) [s].
  struct Press {
    Buttons buttons{};
    double start = 0.0;
    double end = 0.0;
  };
  std::vector<Pose> poses{};  ///< by rising time; straight between them, at rest outside
  std::vector<Press> presses{};
  std::array<int, 3> power_on{};  ///< counts shown before homing = counts of the script + these
  bool homed = true;              ///< at the start
};

/// A leg that is not homed shows its count plus an offset. While homing is on it arms beyond 60
/// degrees of the arm, where libnifalcon's geometry has count 686, and is homed when it comes back
/// inward through count 0, the index mark at 35 degrees. The mark's place is inferred from the
/// procedure that users follow, not documented.
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
  std::size_t segment_ = 0;  ///< of the pose that was last reached
  std::array<bool, 3> armed_{};
  std::array<bool, 3> homed_{};
};

}  // namespace palpate::device::falcon
