// SPDX-License-Identifier: MIT
#pragma once
/// What a haptic loop sees of a device, whatever it is: emulated, behind a wire, or a test rig.

#include <Eigen/Core>
#include <array>

namespace palpate::device {

struct DeviceSample {
  Eigen::Vector3d position{0.0, 0.0, 0.0};  ///< of the grip [m], frame of the device
  bool answered = true;                     ///< false: no reply came, the position is an old one
  bool homed = true;                        ///< false: the position means nothing yet
  std::array<bool, 4> buttons{};
};

class HapticDevice {
 public:
  virtual ~HapticDevice() = default;
  /// One request and its reply: from now on the device pulls the hand with `force` [N], frame of
  /// the device; the sample is of this instant.
  virtual DeviceSample exchange(const Eigen::Vector3d& force) noexcept = 0;
};

}  // namespace palpate::device
