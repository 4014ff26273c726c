// SPDX-License-Identifier: MIT
#pragma once
/// Equation of motion of the Falcon with a hand at its grip (device/README.md, "Motion"): position
/// and velocity of the grip are the state, the arms follow through the exact kinematics.

#include <Eigen/Core>

#include "device/falcon/friction.hpp"
#include "device/falcon/kinematics.hpp"
#include "device/hand.hpp"

namespace palpate::device::falcon {

/// No Falcon's inertia, friction or stops are published: these are estimates. Masses and inertia
/// are of the size that S. Martin's ultimate gains (ros_falcon) imply; vary all from half to
/// double.
struct PlantOptions {
  double effector_mass = 0.13;    ///< with the grip [kg]
  double tool_mass = 0.0;         ///< mounted on the grip [kg]
  double arm_inertia = 4e-4;      ///< of one leg about its base joint, with the motor's [kg m^2]
  double gravity = 9.80665;       ///< along -y, on effector and tool [m/s^2]
  double coulomb = 4e-3;          ///< friction of each arm [N m]
  double viscosity = 2e-4;        ///< of each arm [N m s/rad]
  double inner_stop = -0.40;      ///< theta1 [rad]; -23 deg
  double outer_stop = 1.62;       ///< theta1 [rad]; 93 deg
  double elbow_stop = 0.105;      ///< least angle between thigh and shin's projection [rad]; 6 deg
  double swing_stop = 1.02;       ///< most that a shin leans out of its leg's plane [rad]; 58 deg
  double stop_stiffness = 100.0;  ///< [N m/rad]
  double stop_viscosity = 0.2;    ///< [N m s/rad], only while it pushes back
  double substep = 50e-6;         ///< longest step of the integrator [s]
};

/// What is given at an instant.
struct Drive {
  Eigen::Vector3d torque{};  ///< of the motors, arms at rest [N m]
  double speed_share = 0.0;  ///< see MotorOptions
  IntentPoint intent{};
};

using PlantState = Eigen::Matrix<double, 16, 1>;

/// Views into a PlantState.
namespace part {
inline constexpr int position = 0, velocity = 3, arm_position = 6, arm_velocity = 9;
inline constexpr int friction_loss = 12, stop_loss = 13, motor_work = 14, hand_work = 15;  // [J]
}  // namespace part

/// One evaluation.
struct Motion {
  PlantState derivative{};
  ArmDynamics arms{};
  Eigen::Vector3d rate{};      ///< theta1' [rad/s]
  Eigen::Vector3d friction{};  ///< Coulomb's torque [N m]
};

class Mechanics {
 public:
  Mechanics(const Kinematics& kinematics, const PlantOptions& options);

  /// False when the position is beyond reach; then `motion` is unspecified.
  bool evaluate(const PlantState& state, const Drive& drive, const Hand& hand, const Slip& slip,
                Motion& motion) const noexcept;

  /// Velocity nearest to this one, in the metric of the kinetic energy, at which no stuck arm
  /// moves.
  [[nodiscard]] Eigen::Vector3d held(const PlantState& state, const Hand& hand,
                                     const Slip& slip) const noexcept;

  /// Of effector, tool, hand and arms [J].
  [[nodiscard]] double kinetic(const PlantState& state, const Hand& hand) const noexcept;
  /// Height and strained stops [J].
  [[nodiscard]] double potential(const PlantState& state) const noexcept;

  [[nodiscard]] const Kinematics& kinematics() const noexcept { return kinematics_; }
  [[nodiscard]] const PlantOptions& options() const noexcept { return options_; }

 private:
  /// Force on the grip [N], energy stored [J], power lost [W].
  struct Stops {
    Eigen::Vector3d force = Eigen::Vector3d::Zero();
    double energy = 0.0;
    double loss = 0.0;
  };
  /// Everything but Coulomb friction.
  struct Applied {
    HandForces hand{};
    Stops stops{};
    Eigen::Vector3d curvature{};  ///< arms' acceleration at constant velocity [rad/s^2]
    Eigen::Vector3d motors{};     ///< [N m]
    Eigen::Vector3d force{};      ///< on the grip, all together [N]
  };
  [[nodiscard]] Applied applied(const std::array<Leg, 3>& legs, const PlantState& state,
                                const Drive& drive, const Hand& hand) const noexcept;
  void press(Stops& stops, double depth, double rate, const Eigen::Vector3d& slope) const noexcept;
  [[nodiscard]] Stops stops_at(const std::array<Leg, 3>& legs, const Eigen::Vector3d& position,
                               const Eigen::Vector3d& velocity) const noexcept;
  [[nodiscard]] Eigen::Vector3d elbow_slope(int index, const Leg& leg,
                                            const Eigen::Vector3d& position) const noexcept;
  [[nodiscard]] double grip_mass(const Hand& hand) const noexcept {
    return options_.effector_mass + options_.tool_mass + hand.impedance.mass;
  }
  [[nodiscard]] Eigen::Matrix3d inverse_mass(const Eigen::Matrix3d& slope,
                                             const Hand& hand) const noexcept;

  Kinematics kinematics_;
  PlantOptions options_;
  Eigen::Vector2d inner_;  ///< cosine and sine of the stop
  Eigen::Vector2d outer_;
  double widest_;  ///< |v + f| at the swing stop [m]
};

}  // namespace palpate::device::falcon
