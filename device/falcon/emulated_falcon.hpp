// SPDX-License-Identifier: MIT
#pragma once
/// Emulated Falcon in lock step with its caller: driver, wire, firmware, motors, mechanism and hand
/// in one process and in virtual time.

#include "device/byte_link.hpp"
#include "device/falcon/driver.hpp"
#include "device/falcon/emulator.hpp"
#include "device/falcon/plant.hpp"
#include "device/haptic_device.hpp"

namespace palpate::device::falcon {

struct EmulatedFalconOptions {
  PlantBodyOptions body{};
  bool stock_profile = false;  ///< reproduce libnifalcon's driver defects; requires `wire`
  /// If true, counts, words and packets are exchanged; if false, exact positions and torques.
  bool wire = true;
  FaultScript faults{};
};

class EmulatedFalcon final : public HapticDevice {
 public:
  EmulatedFalcon(const EmulatedFalconOptions& options, const Hand& hand);

  /// Exchanges one force and one sample, over the emulated wire or directly.
  DeviceSample exchange(const Eigen::Vector3d& force) noexcept override;
  /// Advances the clock to `time` [s]. Packets take no time.
  void run_until(double time) noexcept;

  [[nodiscard]] double time() const noexcept { return body_.plant().time(); }  ///< [s]
  [[nodiscard]] const PlantBody& body() const noexcept { return body_; }
  [[nodiscard]] Hand& hand() noexcept { return body_.hand(); }
  /// Returns true if a word of the last request was clamped or wrapped, or supply or heat limit the
  /// motors.
  [[nodiscard]] bool saturated() const noexcept { return saturated_ || body_.limited(); }
  /// Sets the observer of all packets. The observer must outlive this object.
  void observe(EmulatorObserver* observer) noexcept { emulator_.observe(observer); }
  [[nodiscard]] const DriverCounts& counts() const noexcept { return driver_.counts(); }

 private:
  DeviceSample exchange_packets(const Eigen::Vector3d& force) noexcept;

  EmulatedFalconOptions options_;
  Kinematics kinematics_;
  PlantBody body_;
  MemoryLink link_{Emulator::body_step};
  Emulator emulator_;
  Driver driver_;
  DriverProfile profile_;
  Eigen::Vector3d place_;                             ///< position reported by the driver [m]
  bool homed_ = true;                                 ///< homing state in the last reply
  Eigen::Vector3d torque_ = Eigen::Vector3d::Zero();  ///< torque without the wire [N m]
  bool saturated_ = false;
};

}  // namespace palpate::device::falcon
