// SPDX-License-Identifier: MIT
#include "device/hand.hpp"

namespace palpate::device {
namespace {

Eigen::Vector3d pull(const HandImpedance& impedance, const Eigen::Vector3d& stretch,
                     const Eigen::Vector3d& stretch_rate) noexcept {
  return impedance.stiffness * stretch + impedance.viscosity * stretch_rate;
}

/// Of the last stage toward the intent; a push replaces its spring along the axis.
Eigen::Vector3d toward_intent(const HandImpedance& impedance, const Eigen::Vector3d& axis,
                              const IntentPoint& intent, const Eigen::Vector3d& position,
                              const Eigen::Vector3d& velocity) noexcept {
  Eigen::Vector3d stretch = intent.position - position;
  if (intent.pushing) { stretch -= axis * axis.dot(stretch); }
  return pull(impedance, stretch, intent.velocity - velocity) + intent.push * axis;
}

}  // namespace

HandForces hand_forces(const Hand& hand, const IntentPoint& intent,
                       const Eigen::Vector3d& grip_position, const Eigen::Vector3d& grip_velocity,
                       const ArmMotion& arm) noexcept {
  const Eigen::Vector3d& axis = hand.intent.direction();
  if (!hand.arm) {
    return {.on_grip = toward_intent(hand.impedance, axis, intent, grip_position, grip_velocity),
            .on_arm = Eigen::Vector3d::Zero()};
  }
  const Eigen::Vector3d between =
      pull(hand.impedance, arm.position - grip_position, arm.velocity - grip_velocity);
  return {.on_grip = between,
          .on_arm = toward_intent(*hand.arm, axis, intent, arm.position, arm.velocity) - between};
}

}  // namespace palpate::device
