// SPDX-License-Identifier: MIT
#include "device/falcon/force_limits.hpp"

namespace palpate::device::falcon {

double largest_force(const Eigen::Matrix3d& jacobian, const Eigen::Vector3d& direction,
                     double largest_torque) noexcept {
  return largest_torque / (jacobian.transpose() * direction).cwiseAbs().maxCoeff();
}

WeakestDirection weakest_direction(const Eigen::Matrix3d& jacobian,
                                   double largest_torque) noexcept {
  Eigen::Index leg = 0;
  const double longest = jacobian.colwise().norm().maxCoeff(&leg);
  return {.direction = jacobian.col(leg) / longest, .force = largest_torque / longest};
}

}  // namespace palpate::device::falcon
