// SPDX-License-Identifier: MIT
#pragma once
/// One leg at one position of the grip, without evaluating an angle (device/README.md, "Legs").

#include <Eigen/Core>

#include "device/falcon/geometry.hpp"

namespace palpate::device::falcon {

/// In the leg's plane, seen from the base joint: X outward along the leg, w away from the base.
struct Leg {
  double cosine = 1.0;    ///< of theta1
  double sine = 0.0;      ///< of theta1
  double outward = 0.0;   ///< shin's projection L cos(theta2) [m]
  double away = 0.0;      ///< L sin(theta2) [m]
  double sideways = 0.0;  ///< v + f = b cos(theta3) [m], across the plane
  double height = 0.0;    ///< b sin(theta3) [m]
  double reach = 0.0;     ///< L = d + e + b sin(theta3) [m]
  double lever = 0.0;     ///< a L sin(theta2 - theta1) [m^2]; 0 where thigh and shin are in line
  Eigen::Vector3d closure{};  ///< d(half the squared closure)/d(position) = lever d(theta1)/d(pos)

  /// d(theta1)/d(position) [rad/m].
  [[nodiscard]] Eigen::Vector3d rate() const { return closure / lever; }
};

/// Precomputed directions of one leg.
struct LegFrame {
  Eigen::Vector3d outward{};   ///< u
  Eigen::Vector3d sideways{};  ///< v
};

/// |v + f| / b beyond which a leg does not reach: the parallelogram is folded flat at 1, where the
/// derivatives are infinite.
inline constexpr double widest_swing = 1.0 - 1e-4;

enum class Reach { within, beyond };

/// Fills `leg`. Where the position is beyond reach, or behind the base plane, `leg` is left
/// unspecified. The branch is the mechanism's: knee outside.
Reach solve_leg(const Geometry& geometry, const LegFrame& frame, const Eigen::Vector3d& position,
                Leg& leg) noexcept;

/// theta1'' at constant velocity of the grip: the part of the arm's acceleration that comes from
/// the curvature of theta1(position) [rad/s^2].
double curvature_acceleration(const Geometry& geometry, const LegFrame& frame, const Leg& leg,
                              const Eigen::Vector3d& velocity) noexcept;

}  // namespace palpate::device::falcon
