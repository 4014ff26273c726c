// SPDX-License-Identifier: MIT
#pragma once
/// Coulomb friction in the three arms as the set that it is (device/README.md, "Friction"): a
/// sliding arm feels the limit against its motion, a stuck one whatever holds it, up to the limit.

#include <Eigen/Core>
#include <array>

namespace palpate::device::falcon {

using Slip = std::array<int, 3>;  ///< sign of each arm's rate; 0: stuck

/// The arms' accelerations are free + mobility x torque.
struct ArmDynamics {
  Eigen::Matrix3d mobility{};  ///< [rad/s^2 per N m], symmetric and positive
  Eigen::Vector3d free{};      ///< without Coulomb friction [rad/s^2]
};

/// Torques [N m] that keep the stuck arms from accelerating while the others slide. What holds an
/// arm may come out beyond the limit: then it cannot stay stuck.
Eigen::Vector3d friction_torque(const ArmDynamics& arms, const Slip& slip, double limit) noexcept;

/// Which of the arms at rest (0 in `slip`) stay stuck and which way the others start. The solution
/// is unique: it minimises a strictly convex function in the box of the limit.
Slip settled(const ArmDynamics& arms, const Slip& slip, double limit) noexcept;

}  // namespace palpate::device::falcon
