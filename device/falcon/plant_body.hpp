// SPDX-License-Identifier: MIT
#pragma once
/// The body of an emulated Falcon with all its physics: a hand holds the grip, the motors pull at
/// it, the encoders count.

#include <cstdint>

#include "device/falcon/body.hpp"
#include "device/falcon/encoders.hpp"
#include "device/falcon/plant.hpp"

namespace palpate::device::falcon {

struct PlantBodyOptions {
  Geometry geometry = libnifalcon();
  PlantOptions plant{};
  MotorOptions motors{};
  EncoderOptions encoders{};
  Eigen::Vector3d start{0.0, 0.0, 0.125};  ///< of the grip, at rest [m]
  bool homed = true;                       ///< at power-on; false: encoders begin anywhere
  /// The person homes the device when the host asks for it: the grip all the way out, then in, and
  /// back to the start.
  bool homes = false;
  std::uint64_t seed = 1;                  ///< of the offset at power-on
};

class PlantBody final : public Body {
 public:
  /// Throws std::invalid_argument where the start is beyond reach.
  PlantBody(const PlantBodyOptions& options, const Hand& hand);

  void advance(double duration_s, const std::array<std::int16_t, 3>& words,
               bool homing) noexcept override;
  [[nodiscard]] DevicePacket present() const noexcept override;
  void lose_power() noexcept override;

  /// Torques at the arms [N m] instead of words: exact, not rounded, not clamped.
  void advance_exactly(double duration_s, const Eigen::Vector3d& torque) noexcept;

  [[nodiscard]] const Plant& plant() const noexcept { return plant_; }
  [[nodiscard]] Hand& hand() noexcept { return hand_; }
  [[nodiscard]] const Hand& hand() const noexcept { return hand_; }
  /// What the motors pull the hand with now [N].
  [[nodiscard]] Eigen::Vector3d delivered_force() const noexcept;
  [[nodiscard]] EnergyAudit energy() const noexcept { return plant_.energy(hand_); }

 private:
  void begin_gesture() noexcept;

  PlantBodyOptions options_;
  Kinematics kinematics_;
  Hand hand_;
  Intent gesture_;  ///< of homing, at first; the person's own intent once it has begun
  bool gestured_ = false;
  Plant plant_;
  Motors motors_;
  Encoders encoders_;
};

}  // namespace palpate::device::falcon
