// SPDX-License-Identifier: MIT
#include "device/falcon/force_limits.hpp"

#include <algorithm>
#include <numbers>

#include "device/falcon/kinematics.hpp"
#include "device/seeded.hpp"
#include "tests/check.hpp"

namespace {

using namespace palpate::device::falcon;

constexpr double most = 0.5;  // [N m]

Eigen::Matrix3d jacobian_at(const Eigen::Vector3d& position) {
  return jacobian(*Kinematics{}.legs(position));
}

const std::vector<Eigen::Vector3d> places{{0.0, 0.0, 0.12}, {0.02, -0.01, 0.11}, {-0.03, 0.02, 0.14}};

/// Unit vectors over the sphere, evenly (Fibonacci's spiral).
std::vector<Eigen::Vector3d> directions(int count) {
  std::vector<Eigen::Vector3d> all;
  for (int n = 0; n < count; ++n) {
    const double z = 1.0 - (2.0 * n + 1.0) / count;
    const double angle = std::numbers::pi * (3.0 - std::sqrt(5.0)) * n;
    const double r = std::sqrt(1.0 - z * z);
    all.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
  }
  return all;
}

TEST("every corner needs each motor's whole torque, with the sense that its index tells") {
  for (const Eigen::Vector3d& place : places) {
    const Eigen::Matrix3d j = jacobian_at(place);
    const auto corners = force_corners(j, most);
    for (unsigned n = 0; n < 8; ++n) {
      const Eigen::Vector3d torque = j.transpose() * corners[n];
      for (unsigned leg = 0; leg < 3; ++leg) {
        CHECK_NEAR(torque(leg), (n >> leg & 1U) != 0U ? most : -most, 1e-12);  // rounding
      }
    }
  }
}

TEST("the largest force along a direction is where a motor reaches its limit, and no further") {
  for (const Eigen::Vector3d& place : places) {
    const Eigen::Matrix3d j = jacobian_at(place);
    for (const Eigen::Vector3d& along : directions(500)) {
      const Eigen::Vector3d torque = j.transpose() * (largest_force(j, along, most) * along);
      CHECK_NEAR(torque.cwiseAbs().maxCoeff(), most, 1e-12);
    }
  }
}

TEST("no direction is weaker than the weakest one") {
  for (const Eigen::Vector3d& place : places) {
    const Eigen::Matrix3d j = jacobian_at(place);
    const WeakestDirection weakest = weakest_direction(j, most);
    CHECK_NEAR(weakest.direction.norm(), 1.0, 1e-12);
    CHECK_NEAR(largest_force(j, weakest.direction, most), weakest.force, 1e-12);
    for (const Eigen::Vector3d& along : directions(2000)) {
      CHECK(largest_force(j, along, most) >= weakest.force * (1.0 - 1e-12));
    }
  }
}

}  // namespace
