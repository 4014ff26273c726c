// SPDX-License-Identifier: MIT
#pragma once
/// Lengths, angles and gearing of a Falcon (device/README.md, "Legs"). Frame of libnifalcon:
/// x right, y up, z toward the user, origin in the plane of the base joints on its axis.

#include <array>
#include <numbers>

namespace palpate::device::falcon {

/// Only five lengths enter the kinematics: thigh, shin, link_offset(), radial_offset() and
/// lateral_offset(). Absolute positions are uncertain at 3 mm: so far apart are the published sets.
struct Geometry {
  double thigh = 0.060;              ///< a [m] base joint to knee
  double shin = 0.1025;              ///< b [m] side of the parallelogram
  double knee_offset = 0.01125;      ///< d [m]
  double foot_offset = 0.01125;      ///< e [m]
  double effector_radius = 0.01443;  ///< c [m]
  double effector_lateral = -0.025;  ///< f [m]
  double base_radius = 0.040;        ///< r [m]
  double base_lateral = -0.02309;    ///< s [m]
  std::array<double, 3> azimuth{};   ///< of legs 1, 2, 3: top, right, left [rad]
  double reduction = 110.0 / 14.25;  ///< turns of the motor per turn of the arm [1]
  double counts_per_turn = 1280.0;   ///< of the motor: 320 slots, four edges each
  double zero_angle = 0.0;           ///< theta1 at count 0 [rad]

  [[nodiscard]] double link_offset() const { return knee_offset + foot_offset; }
  [[nodiscard]] double radial_offset() const { return base_radius - effector_radius; }
  [[nodiscard]] double lateral_offset() const { return effector_lateral - base_lateral; }
  /// Of the arm [counts/rad].
  [[nodiscard]] double counts_per_radian() const {
    return counts_per_turn * reduction / (2.0 * std::numbers::pi);
  }
};

/// The constants that libnifalcon drives the device with (its FalconGeometry.h); the default.
Geometry libnifalcon();

/// Measured by S. Martin and N. Hillier, "Characterisation of the Novint Falcon haptic device for
/// application as a robot manipulator", ACRA 2009, as RReichert/Falcon passes them on. Its f and s
/// count the other way round: they are negated here, so that f - s = +1.0 mm in libnifalcon's sign.
/// Its sources disagree on the zero (35, 40 and 50 degrees); 35 is libnifalcon's.
Geometry martin_hillier();

}  // namespace palpate::device::falcon
