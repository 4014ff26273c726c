// SPDX-License-Identifier: MIT
#include "model/stepping/spring_blocks.hpp"

#include "model/dynamics/spring_force.hpp"

namespace palpate::spring_blocks {

std::optional<Matrix3d> block_of(const SpringList::Bond& bond, const Vector3d& d, Which which) {
  const double length = d.norm();
  if (length < zero_length) { return {}; }
  const Vector3d u = d / length;
  const Matrix3d along = u * u.transpose();
  if (which == Which::damping) { return bond.viscosity * along; }
  double tension = bond.stiffness * (length - bond.rest_length);
  if (which == Which::stretched_stiffness) { tension = std::max(0.0, tension); }
  return bond.stiffness * along + tension / length * (Matrix3d::Identity() - along);
}

}  // namespace palpate::spring_blocks
