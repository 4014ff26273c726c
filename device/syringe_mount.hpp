// SPDX-License-Identifier: MIT
#pragma once
/// A syringe with its needle, fixed rigidly to the grip of a device that does not turn.

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace palpate::device {

struct SyringeMount {
  Eigen::Vector3d grip_to_tip{0.0, 0.0, -0.10};  ///< device frame [m]
  double mass = 0.02;                            ///< goes into the plant's tool_mass [kg]

  [[nodiscard]] Eigen::Vector3d tip(const Eigen::Vector3d& grip) const noexcept {
    return grip + grip_to_tip;
  }
  [[nodiscard]] Eigen::Vector3d grip(const Eigen::Vector3d& tip) const noexcept {
    return tip - grip_to_tip;
  }
  /// Torque about the grip [N m] of a force at the tip [N]. A hand on a real syringe feels it; a
  /// device without rotation cannot render it: the force alone goes to the grip, unchanged.
  [[nodiscard]] Eigen::Vector3d unrendered_torque(const Eigen::Vector3d& force) const noexcept {
    return grip_to_tip.cross(force);
  }
};

}  // namespace palpate::device
