// SPDX-License-Identifier: MIT
#pragma once
/// Lengths, angles and gearing of a Falcon (device/README.md, "Legs"). Frame of libnifalcon:
/// x right, y up, z toward the user, origin in the plane of the base joints on its axis.

#include <Eigen/Core>
#include <array>
#include <numbers>
#include <optional>

namespace palpate::device::falcon {

/// Geometry of a Falcon. Only five lengths enter the kinematics: thigh, shin, link_offset(),
/// radial_offset() and lateral_offset(). The published sets differ by 3 mm in absolute position.
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
  double counts_per_turn = 1280.0;   ///< per turn of the motor: 320 slots, four edges each
  double zero_angle = 0.0;           ///< theta1 at count 0 [rad]

  [[nodiscard]] double link_offset() const { return knee_offset + foot_offset; }
  [[nodiscard]] double radial_offset() const { return base_radius - effector_radius; }
  [[nodiscard]] double lateral_offset() const { return effector_lateral - base_lateral; }
  /// Encoder counts per angle of the arm [counts/rad].
  [[nodiscard]] double counts_per_radian() const {
    return counts_per_turn * reduction / (2.0 * std::numbers::pi);
  }
};

/// Returns the constants of libnifalcon (FalconGeometry.h), which are the default.
Geometry libnifalcon();

/// Returns the geometry measured by S. Martin and N. Hillier, "Characterisation of the Novint
/// Falcon haptic device for application as a robot manipulator", ACRA 2009, as published in
/// RReichert/Falcon. Its f and s have the opposite sign and are negated here: f - s = +1.0 mm in
/// libnifalcon's convention. Its sources disagree on the zero (35, 40 and 50 degrees);
/// libnifalcon's 35 is used.
Geometry martin_hillier();

// Kinematics of one leg at one position of the grip, without evaluating an angle (device/README.md,
// "Legs").

/// State of one leg in its own plane, relative to the base joint: X points outward along the leg, w
/// away from the base.
struct Leg {
  double cosine = 1.0;        ///< cos(theta1)
  double sine = 0.0;          ///< sin(theta1)
  double outward = 0.0;       ///< projection of the shin, L cos(theta2) [m]
  double away = 0.0;          ///< L sin(theta2) [m]
  double sideways = 0.0;      ///< v + f = b cos(theta3) [m], across the plane
  double height = 0.0;        ///< b sin(theta3) [m]
  double reach = 0.0;         ///< L = d + e + b sin(theta3) [m]
  double lever = 0.0;         ///< a L sin(theta2 - theta1) [m^2]; 0 if thigh and shin are collinear
  Eigen::Vector3d closure{};  ///< d(half the squared closure)/d(position) = lever d(theta1)/d(pos)

  /// Returns d(theta1)/d(position) [rad/m].
  [[nodiscard]] Eigen::Vector3d rate() const { return closure / lever; }
};

/// Precomputed directions of one leg.
struct LegFrame {
  Eigen::Vector3d outward{};   ///< u
  Eigen::Vector3d sideways{};  ///< v
};

/// Returns theta1'' at constant velocity of the grip [rad/s^2]: the part of the arm's acceleration
/// due to the curvature of theta1(position).
double curvature_acceleration(const Geometry& geometry, const LegFrame& frame, const Leg& leg,
                              const Eigen::Vector3d& velocity) noexcept;

// Kinematics of the Falcon (device/README.md, "Legs"): positions [m] in libnifalcon's frame; arm
// angles [rad] and torques at the arms [N m] are positive outward. No function allocates. After R.
// E. Stamper, PhD thesis, University of Maryland 1997, chapters 2-4, with the lateral offset that
// A. Barrow added in libnifalcon.

/// Joint angles of legs 1, 2, 3 [rad].
struct LegAngles {
  Eigen::Vector3d theta1{};  ///< arm, from the base plane
  Eigen::Vector3d theta2{};  ///< shin's projection, from the base plane
  Eigen::Vector3d theta3{};  ///< shin, from the leg's side
};

class Kinematics {
 public:
  explicit Kinematics(const Geometry& geometry = libnifalcon());
  [[nodiscard]] const Geometry& geometry() const noexcept { return geometry_; }

  /// Centre of the workspace [m], the default initial guess of forward().
  static Eigen::Vector3d centre() { return {0.0, 0.0, 0.125}; }
  static Eigen::Vector3d cold_start() { return {0.0, 0.0, 0.120}; }

  /// Returns the three legs at a position. Returns nothing beyond the reach or if the position
  /// belongs to another assembly of the mechanism. Joint stops are ignored.
  [[nodiscard]] std::optional<std::array<Leg, 3>> legs(
      const Eigen::Vector3d& position) const noexcept;
  /// Returns the arm angles in closed form. The error is below 1e-12 rad except within 1e-9 m of
  /// the edge of the reach.
  [[nodiscard]] std::optional<LegAngles> inverse(const Eigen::Vector3d& position) const noexcept;
  /// Computes the position by Newton's method on the three squared closures, with steps of at most
  /// 30 mm. If this fails or finds another assembly, it restarts from three rings around the
  /// workspace. The error is below 1e-12 m. Returns nothing if the mechanism cannot have these
  /// angles.
  [[nodiscard]] std::optional<Eigen::Vector3d> forward(
      const Eigen::Vector3d& theta1, const Eigen::Vector3d& start = cold_start()) const noexcept;

  /// Returns J = d(position)/d(theta1) [m/rad]; each column is a leg.
  [[nodiscard]] std::optional<Eigen::Matrix3d> jacobian(
      const Eigen::Vector3d& position) const noexcept;

  [[nodiscard]] const LegFrame& frame(int leg) const noexcept {
    return frames_[static_cast<std::size_t>(leg)];
  }

 private:
  /// Computes the halved closures at a guess [m^2] and their derivative [m^2/m].
  void closures(const Eigen::Vector3d& cosine, const Eigen::Vector3d& sine,
                const Eigen::Vector3d& position, Eigen::Matrix3d& slope,
                Eigen::Vector3d& value) const noexcept;
  [[nodiscard]] std::optional<Eigen::Vector3d> newton(const Eigen::Vector3d& theta1,
                                                      const Eigen::Vector3d& start) const noexcept;

  Geometry geometry_;
  std::array<LegFrame, 3> frames_{};
};

/// Returns theta1 of the three arms [rad].
Eigen::Vector3d angles_at_base(const std::array<Leg, 3>& legs) noexcept;

/// Returns d(theta1)/d(position) [rad/m], the inverse of J; singular only at the edge of the reach.
Eigen::Matrix3d inverse_jacobian(const std::array<Leg, 3>& legs) noexcept;
/// Returns J [m/rad] from the same legs, well defined up to the edge of the reach.
Eigen::Matrix3d jacobian(const std::array<Leg, 3>& legs) noexcept;

/// Returns the torques at the arms [N m] with which the device exerts `force_on_hand`: J^T F.
inline Eigen::Vector3d torque_of_force(const Eigen::Matrix3d& jacobian,
                                       const Eigen::Vector3d& force_on_hand) noexcept {
  return jacobian.transpose() * force_on_hand;
}
/// Returns the force on the hand [N] due to torques at the arms, the inverse of torque_of_force().
Eigen::Vector3d force_of_torque(const Eigen::Matrix3d& jacobian,
                                const Eigen::Vector3d& torque) noexcept;

// Set of forces that three bounded torques can produce at one pose: the torque box mapped by J^-T,
// a parallelepiped. The results are exact.

struct WeakestDirection {
  Eigen::Vector3d direction{};  ///< unit vector
  double force = 0.0;           ///< largest force in this direction [N]
};

/// Returns the largest force [N] along a unit direction with no torque above `largest_torque` [N
/// m].
double largest_force(const Eigen::Matrix3d& jacobian, const Eigen::Vector3d& direction,
                     double largest_torque) noexcept;

/// Returns the nearest face of the parallelepiped. Its force is available in every direction.
WeakestDirection weakest_direction(const Eigen::Matrix3d& jacobian, double largest_torque) noexcept;

}  // namespace palpate::device::falcon
