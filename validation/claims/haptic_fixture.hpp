// SPDX-License-Identifier: MIT
#pragma once
/// Device with one mass on a rail and exact motion between ticks, for comparison with theory.

#include "device/haptic_device.hpp"
#include "validation/case.hpp"

namespace palpate::haptics {

/// Device with m x'' + b x' = F along the rail (x of the device) and F constant within a tick;
/// optionally with an encoder and Coulomb friction.
class Rail final : public device::HapticDevice {
 public:
  struct Settings {
    double mass = 0.1;              ///< [kg]
    double viscosity = 0.5;         ///< [N s/m]
    double period = 1e-3;           ///< [s]
    double encoder_step = 0.0;      ///< [m]; 0: exact
    double coulomb_friction = 0.0;  ///< [N]
  };

  explicit Rail(const Settings& settings);

  void put(double place, double velocity) {
    place_ = place;
    velocity_ = velocity;
  }
  device::DeviceSample exchange(const Eigen::Vector3d& force) noexcept override;
  void advance() noexcept;  ///< advances by one period

  [[nodiscard]] double place() const { return place_; }        ///< [m]
  [[nodiscard]] double velocity() const { return velocity_; }  ///< [m/s]
  [[nodiscard]] double read() const;  ///< position read through the encoder [m]

 private:
  void glide(double force, double time) noexcept;

  Settings settings_;
  double force_ = 0.0;
  double place_ = 0.0;
  double velocity_ = 0.0;
};

/// Two-sided virtual wall at 0 with damping from a backward difference.
class Wall {
 public:
  Wall(double stiffness, double damping, double period)
      : stiffness_(stiffness), damping_(damping / period) {}
  [[nodiscard]] Eigen::Vector3d force(const device::DeviceSample& sample) noexcept {
    const double place = sample.position.x();
    const double pull = stiffness_ * place + damping_ * (place - last_);
    last_ = place;
    return {-pull, 0.0, 0.0};
  }
  void touch(double place) { last_ = place; }

 private:
  double stiffness_;
  double damping_;
  double last_ = 0.0;
};

/// Returns the delay [ticks] that a mutation of the loop adds.
int extra_delay(const CaseContext& context);

}  // namespace palpate::haptics
