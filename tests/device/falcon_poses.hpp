// SPDX-License-Identifier: MIT
#pragma once
/// Poses of the grip that tests go through, and the kinematics as Stamper prints them, in long
/// double: nothing of device/ but the lengths is used.

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <vector>

#include "device/falcon/kinematics.hpp"

namespace poses {

using Real = long double;
using Vector = Eigen::Matrix<Real, 3, 1>;

/// theta1, theta2, theta3 of one leg; NaN beyond reach.
inline std::array<Real, 3> leg_angles(const palpate::device::falcon::Geometry& g, std::size_t leg,
                                      const Vector& position) {
  const Real phi = g.azimuth[leg];
  const Real u = position[0] * std::cos(phi) + position[1] * std::sin(phi) - Real(g.base_radius);
  const Real v = -position[0] * std::sin(phi) + position[1] * std::cos(phi) - Real(g.base_lateral);
  const Real a = g.thigh;
  const Real theta3 = std::acos((v + Real(g.effector_lateral)) / Real(g.shin));
  const Real reach = Real(g.knee_offset) + Real(g.foot_offset) + Real(g.shin) * std::sin(theta3);
  const Real outward = u + Real(g.effector_radius);
  const Real distance = std::hypot(outward, position[2]);
  const Real theta1 = std::atan2(position[2], outward) -
                      std::acos((distance * distance + a * a - reach * reach) / (2 * a * distance));
  const Real theta2 =
      std::atan2(position[2] - a * std::sin(theta1), outward - a * std::cos(theta1));
  return {theta1, theta2, theta3};
}

inline Vector theta1(const palpate::device::falcon::Geometry& g, const Vector& position) {
  Vector result;
  for (std::size_t leg = 0; leg < 3; ++leg) {
    result[static_cast<Eigen::Index>(leg)] = leg_angles(g, leg, position)[0];
  }
  return result;
}

/// Every position of a grid over the lens between the joint stops (counts of -1600 to 1600).
inline std::vector<Eigen::Vector3d> reachable(const palpate::device::falcon::Geometry& g,
                                              double spacing = 0.006) {
  constexpr Real degree = 0.017453292519943295769L;
  std::vector<Eigen::Vector3d> result;
  for (double x = -0.11; x < 0.11; x += spacing) {
    for (double y = -0.11; y < 0.11; y += spacing) {
      for (double z = 0.05; z < 0.19; z += spacing) {
        const Vector theta = theta1(g, Eigen::Vector3d(x, y, z).cast<Real>());
        bool within = true;
        for (const Real angle : theta) {
          within = within && angle > -23 * degree && angle < 93 * degree;
        }
        if (within) { result.emplace_back(x, y, z); }
      }
    }
  }
  return result;
}

/// Positions within 10 nm to 1 mm of the outer edge of what the legs reach, found by bisection.
inline std::vector<Eigen::Vector3d> at_the_edge(const palpate::device::falcon::Geometry& g) {
  std::vector<Eigen::Vector3d> result;
  for (int n = 0; n < 400; ++n) {
    const double turn = 2.399963229728653 * n;  // golden angle: even cover of a half sphere
    const double rise = (n + 0.5) / 400.0;
    const double flat = std::sqrt(1.0 - rise * rise);
    const Eigen::Vector3d direction(flat * std::cos(turn), flat * std::sin(turn), rise);
    const Eigen::Vector3d centre(0.0, 0.0, 0.125);
    double inside = 0.0;
    double outside = 0.3;
    for (int bisection = 0; bisection < 60; ++bisection) {
      const double middle = 0.5 * (inside + outside);
      const Eigen::Vector3d point = centre + middle * direction;
      const bool within = theta1(g, point.cast<Real>()).allFinite() && point.z() > 0.0;
      (within ? inside : outside) = middle;
    }
    for (const double gap : {1e-8, 1e-6, 1e-4, 1e-3}) {
      result.push_back(centre + (inside - gap) * direction);
    }
  }
  return result;
}

}  // namespace poses
