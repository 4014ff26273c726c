// SPDX-License-Identifier: MIT
#pragma once
/// Lengths, angles and gearing of a Falcon (device/README.md, "Legs"). Frame of libnifalcon:
/// x right, y up, z toward the user, origin in the plane of the base joints on its axis.

#include <Eigen/Core>
#include <array>
#include <numbers>
#include <optional>

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

// One leg at one position of the grip, without evaluating an angle (device/README.md, "Legs").

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

// Kinematics of the Falcon (device/README.md, "Legs"): positions [m] in libnifalcon's frame, arm
// angles [rad] and torques at the arms [N m] growing outward. Nothing here allocates.
// After R. E. Stamper, PhD thesis, University of Maryland 1997, chapters 2-4, with the lateral
// offset that A. Barrow added in libnifalcon.

/// Of legs 1, 2, 3 [rad].
struct LegAngles {
  Eigen::Vector3d theta1{};  ///< arm, from the base plane
  Eigen::Vector3d theta2{};  ///< shin's projection, from the base plane
  Eigen::Vector3d theta3{};  ///< shin, from the leg's side
};

class Kinematics {
 public:
  explicit Kinematics(const Geometry& geometry = libnifalcon());
  [[nodiscard]] const Geometry& geometry() const noexcept { return geometry_; }

  /// Centre of the workspace, and where a cold forward solution starts.
  static Eigen::Vector3d centre() { return {0.0, 0.0, 0.125}; }
  static Eigen::Vector3d cold_start() { return {0.0, 0.0, 0.120}; }

  /// The three legs at a position; nothing when it is beyond reach, or when the mechanism would
  /// have to collapse on its way there from the centre (another assembly). Joint stops are not
  /// asked.
  [[nodiscard]] std::optional<std::array<Leg, 3>> legs(
      const Eigen::Vector3d& position) const noexcept;
  /// Closed form; error below 1e-12 rad except within 1e-9 m of the edge of reach.
  [[nodiscard]] std::optional<LegAngles> inverse(const Eigen::Vector3d& position) const noexcept;
  /// Newton's method on the three squared closures, no step longer than 30 mm; where that leads
  /// to another assembly or nowhere, it starts again from three rings round the workspace.
  /// Error below 1e-12 m. Nothing when the mechanism cannot stand at these angles.
  [[nodiscard]] std::optional<Eigen::Vector3d> forward(
      const Eigen::Vector3d& theta1, const Eigen::Vector3d& start = cold_start()) const noexcept;

  /// J = d(position)/d(theta1) [m/rad]; the columns are the legs.
  [[nodiscard]] std::optional<Eigen::Matrix3d> jacobian(
      const Eigen::Vector3d& position) const noexcept;

  [[nodiscard]] const LegFrame& frame(int leg) const noexcept {
    return frames_[static_cast<std::size_t>(leg)];
  }

 private:
  /// Derivative [m^2/m] of the halved closures at a guess, and their values [m^2].
  void closures(const Eigen::Vector3d& cosine, const Eigen::Vector3d& sine,
                const Eigen::Vector3d& position, Eigen::Matrix3d& slope,
                Eigen::Vector3d& value) const noexcept;
  [[nodiscard]] std::optional<Eigen::Vector3d> newton(const Eigen::Vector3d& theta1,
                                                      const Eigen::Vector3d& start) const noexcept;

  Geometry geometry_;
  std::array<LegFrame, 3> frames_{};
};

/// theta1 of the three arms [rad].
Eigen::Vector3d angles_at_base(const std::array<Leg, 3>& legs) noexcept;

/// d(theta1)/d(position) [rad/m], the inverse of J; singular only at the edge of reach.
Eigen::Matrix3d inverse_jacobian(const std::array<Leg, 3>& legs) noexcept;
/// J from the same legs, well defined up to the edge of reach.
Eigen::Matrix3d jacobian(const std::array<Leg, 3>& legs) noexcept;

/// Torques at the arms that let the device push with `force_on_hand`: J^T F [N m].
inline Eigen::Vector3d torque_of_force(const Eigen::Matrix3d& jacobian,
                                       const Eigen::Vector3d& force_on_hand) noexcept {
  return jacobian.transpose() * force_on_hand;
}
/// The opposite way: force on the hand [N] of torques at the arms.
Eigen::Vector3d force_of_torque(const Eigen::Matrix3d& jacobian,
                                const Eigen::Vector3d& torque) noexcept;

// The forces that three bounded torques reach at one pose: a box of torques seen through J^-T, a
// parallelepiped. Exact.

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
