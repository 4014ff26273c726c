// SPDX-License-Identifier: MIT

#include "device/servo_loop.hpp"

#include <algorithm>

namespace palpate::device {

Eigen::Vector3d PassivityController::limit(double energy, const Eigen::Vector3d& velocity,
                                           const Eigen::Vector3d& force) noexcept {
  const double speed_squared = velocity.squaredNorm();
  if (energy >= 0.0 || speed_squared == 0.0) { return force; }
  const double viscosity = std::min(-energy / (period_ * speed_squared), most_viscosity_);
  taken_ += viscosity * speed_squared * period_;
  return force - viscosity * velocity;
}

}  // namespace palpate::device
