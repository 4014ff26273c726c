// SPDX-License-Identifier: MIT
#include "device/falcon/force_limits.hpp"

#include <Eigen/LU>

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

std::array<Eigen::Vector3d, 8> force_corners(const Eigen::Matrix3d& jacobian,
                                             double largest_torque) noexcept {
  const Eigen::Matrix3d force_of_torque = jacobian.transpose().inverse();
  std::array<Eigen::Vector3d, 8> corners;
  for (unsigned corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d torque;
    for (unsigned leg = 0; leg < 3; ++leg) {
      torque(leg) = (corner >> leg & 1U) != 0U ? largest_torque : -largest_torque;
    }
    corners[corner] = force_of_torque * torque;
  }
  return corners;
}

}  // namespace palpate::device::falcon
