// SPDX-License-Identifier: MIT
#pragma once
/// The forces that three bounded torques reach at one pose: a box of torques seen through J^-T, a
/// parallelepiped. Exact.

#include <array>

#include <Eigen/Core>

namespace palpate::device::falcon {

struct WeakestDirection {
  Eigen::Vector3d direction{};  ///< unit
  double force = 0.0;           ///< largest along it [N]
};

/// Largest force [N] along a unit direction with no torque beyond `largest_torque` [N m].
double largest_force(const Eigen::Matrix3d& jacobian, const Eigen::Vector3d& direction,
                     double largest_torque) noexcept;

/// The nearest face of the parallelepiped: every direction can have this force.
WeakestDirection weakest_direction(const Eigen::Matrix3d& jacobian, double largest_torque) noexcept;

/// The corners of the parallelepiped [N]; bit n of an index is the sense of leg n's torque.
std::array<Eigen::Vector3d, 8> force_corners(const Eigen::Matrix3d& jacobian,
                                             double largest_torque) noexcept;

}  // namespace palpate::device::falcon
