// SPDX-License-Identifier: MIT
#pragma once
/// Interface of a haptic device: emulated, connected by a wire, or a test fixture.

#include <Eigen/Core>

namespace palpate::device {

/// State of a haptic device at one instant.
struct DeviceSample {
  Eigen::Vector3d position{0.0, 0.0, 0.0};  ///< of the grip [m], frame of the device
  bool answered = true;                     ///< false: no reply, and the position is an older one
  bool homed = true;                        ///< false: the position is not valid yet
};

class HapticDevice {
 public:
  virtual ~HapticDevice() = default;
  /// Performs one request and reply. The device then applies `force` [N] to the hand, in the frame
  /// of the device, until the next call. The sample is of this instant.
  virtual DeviceSample exchange(const Eigen::Vector3d& force) noexcept = 0;
};

}  // namespace palpate::device
