// SPDX-License-Identifier: MIT
#pragma once
/// Coulomb friction in the three arms as a set-valued law (device/README.md, "Friction"): on a
/// sliding arm the limit acts against the motion; on a stuck arm the holding torque is at most the
/// limit.

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "device/falcon/body.hpp"
#include "device/falcon/kinematics.hpp"
#include "device/falcon/motors_encoders.hpp"
#include "device/hand.hpp"

namespace palpate::device::falcon {

using Slip = std::array<int, 3>;  ///< sign of each arm's rate; 0: stuck

/// Dynamics of the arms: acceleration = free + mobility x torque.
struct ArmDynamics {
  Eigen::Matrix3d mobility{};  ///< [rad/s^2 per N m], symmetric and positive
  Eigen::Vector3d free{};      ///< without Coulomb friction [rad/s^2]
};

/// Returns the torques [N m] that keep the stuck arms from accelerating while the others slide. A
/// holding torque may exceed the limit; then the arm cannot stay stuck.
Eigen::Vector3d friction_torque(const ArmDynamics& arms, const Slip& slip, double limit) noexcept;

/// Returns which arms at rest (0 in `slip`) stay stuck and the direction in which the others start.
/// The solution is unique: it minimises a strictly convex function in the box of the limit.
Slip settled(const ArmDynamics& arms, const Slip& slip, double limit) noexcept;

// Equation of motion of the Falcon with a hand at its grip (device/README.md, "Motion"). The state
// is position and velocity of the grip; the arms follow from the exact kinematics.

/// Mechanical parameters of the Falcon. Inertia, friction and stops are not published: these are
/// estimates, of the size implied by S. Martin's ultimate gains (ros_falcon). Vary all from half to
/// double.
struct PlantOptions {
  double effector_mass = 0.13;  ///< with the grip [kg]
  double tool_mass = 0.0;       ///< mounted on the grip [kg]
  double arm_inertia = 4e-4;    ///< of one leg about its base joint, with the motor's [kg m^2]
  double gravity = 9.80665;     ///< along -y, on effector and tool [m/s^2]
  double coulomb = 4e-3;        ///< friction of each arm [N m]
  double viscosity = 2e-4;      ///< of each arm [N m s/rad]
  double inner_stop = -0.40;    ///< theta1 [rad]; -23 deg
  double outer_stop = 1.62;     ///< theta1 [rad]; 93 deg
  double elbow_stop = 0.105;    ///< smallest angle between thigh and projected shin [rad]; 6 deg
  double swing_stop = 1.02;  ///< largest angle of a shin out of the plane of its leg [rad]; 58 deg
  double stop_stiffness = 100.0;  ///< [N m/rad]
  double stop_viscosity = 0.2;    ///< [N m s/rad], only while it decelerates the arm
  double substep = 50e-6;         ///< longest step of the integrator [s]
};

/// Inputs of the equation of motion at one instant.
struct Drive {
  Eigen::Vector3d torque{};  ///< motor torques with the arms at rest [N m]
  IntentPoint intent{};
};

using PlantState = Eigen::Matrix<double, 16, 1>;

/// Segments of a PlantState.
namespace part {
inline constexpr int position = 0, velocity = 3, arm_position = 6, arm_velocity = 9;
inline constexpr int friction_loss = 12, stop_loss = 13, motor_work = 14, hand_work = 15;  // [J]
}  // namespace part

/// Result of one evaluation of the equation of motion.
struct Motion {
  PlantState derivative{};
  ArmDynamics arms{};
  Eigen::Vector3d rate{};      ///< theta1' [rad/s]
  Eigen::Vector3d friction{};  ///< Coulomb friction torque [N m]
};

class Mechanics {
 public:
  Mechanics(const Kinematics& kinematics, const PlantOptions& options);

  /// Evaluates the motion. Returns false if the position is beyond the reach; then `motion` is
  /// unspecified.
  bool evaluate(const PlantState& state, const Drive& drive, const Hand& hand, const Slip& slip,
                Motion& motion) const noexcept;

  /// Returns the velocity nearest to the present one in the metric of the kinetic energy at which
  /// no stuck arm moves [m/s].
  [[nodiscard]] Eigen::Vector3d held(const PlantState& state, const Hand& hand,
                                     const Slip& slip) const noexcept;

  /// Returns the kinetic energy of effector, tool, hand and arms [J].
  [[nodiscard]] double kinetic(const PlantState& state, const Hand& hand) const noexcept;
  /// Returns the potential energy of gravity and of the stops [J].
  [[nodiscard]] double potential(const PlantState& state) const noexcept;

  [[nodiscard]] const Kinematics& kinematics() const noexcept { return kinematics_; }
  [[nodiscard]] const PlantOptions& options() const noexcept { return options_; }

 private:
  /// Contribution of the stops: force on the grip [N], stored energy [J], dissipated power [W].
  struct Stops {
    Eigen::Vector3d force = Eigen::Vector3d::Zero();
    double energy = 0.0;
    double loss = 0.0;
  };
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
  Eigen::Vector2d inner_;  ///< cosine and sine of the inner stop
  Eigen::Vector2d outer_;
  double widest_;  ///< |v + f| at the swing stop [m]
};

// Motion of the emulated mechanism (device/README.md, "Motion"): classical Runge-Kutta of order 4
// between stick and slip events, which are located to 1e-12 of a step. The same calls give the same
// bits. No function allocates or locks.

/// Energy balance since the plant was placed [J]. Losses are positive.
struct EnergyAudit {
  double kinetic = 0.0;    ///< effector, tool, arms, and the hand's mass at the grip
  double potential = 0.0;  ///< gravity and stops
  double friction_loss = 0.0;
  double stop_loss = 0.0;
  double motor_work = 0.0;  ///< done on the mechanism
  double hand_work = 0.0;   ///< done by the hand's springs and dampers on the grip
  double at_start = 0.0;    ///< kinetic + potential at the start
  /// Returns the energy error of the integrator [J]; 0 in exact arithmetic.
  [[nodiscard]] double imbalance() const {
    return kinetic + potential - at_start + friction_loss + stop_loss - motor_work - hand_work;
  }
};

class Plant {
 public:
  explicit Plant(const Kinematics& kinematics = Kinematics(), const PlantOptions& options = {});

  /// Places the grip with this velocity and restarts the energy audit. Returns false and does
  /// nothing if the position is beyond the reach.
  bool place(const Eigen::Vector3d& position, const Hand& hand,
             const Eigen::Vector3d& velocity = Eigen::Vector3d::Zero()) noexcept;

  /// Advances by `duration` [s] with the motors following their last words.
  void advance(double duration, Motors& motors, const Hand& hand) noexcept;

  [[nodiscard]] double time() const noexcept { return time_; }  ///< [s]
  [[nodiscard]] Eigen::Vector3d position() const noexcept {
    return state_.segment<3>(part::position);
  }
  [[nodiscard]] Eigen::Vector3d velocity() const noexcept {
    return state_.segment<3>(part::velocity);
  }
  [[nodiscard]] Eigen::Vector3d theta1() const noexcept;  ///< [rad]
  [[nodiscard]] const Slip& slip() const noexcept { return slip_; }
  /// Number of substeps that would have left the reach and ended at rest instead.
  [[nodiscard]] long halts() const noexcept { return halts_; }
  [[nodiscard]] EnergyAudit energy(const Hand& hand) const noexcept;
  [[nodiscard]] const Mechanics& mechanics() const noexcept { return mechanics_; }

 private:
  struct Given {
    const Motors& motors;
    const Hand& hand;
    double begin = 0.0;  ///< start of this call [s]
  };
  [[nodiscard]] static Drive drive_at(const Given& given, double time) noexcept;
  struct Reached {
    PlantState state;
    Motion motion;  ///< motion at that state
  };
  void settle(const Given& given) noexcept;
  /// Evaluates the motion at the present state; returns false beyond the reach.
  bool look(const Given& given) noexcept;
  bool trial(const Given& given, double duration, Reached& end) const noexcept;
  /// Returns the smallest of the quantities that must stay positive for the present slip.
  double lawfulness(const Motion& motion, Slip& broken) const noexcept;
  double next_event(const Given& given, double duration, double at_end) const noexcept;
  void substep(const Given& given, double duration) noexcept;
  void accept(const Given& given, const Reached& end, double duration) noexcept;
  void halt(const Given& given, double duration) noexcept;

  Mechanics mechanics_;
  PlantState state_ = PlantState::Zero();
  Motion now_{};  ///< motion at the present state, if already evaluated
  bool now_known_ = false;
  Slip slip_{};
  double time_ = 0.0;
  double energy_at_start_ = 0.0;
  long halts_ = 0;
  bool arm_placed_ = false;
};

// Body of an emulated Falcon with full physics: hand, motors, mechanism and encoders.

struct PlantBodyOptions {
  Geometry geometry = libnifalcon();
  PlantOptions plant{};
  MotorOptions motors{};
  EncoderOptions encoders{};
  Eigen::Vector3d start{0.0, 0.0, 0.125};  ///< position of the grip at rest [m]
  bool homed = true;  ///< at power-on; false: encoders have an arbitrary offset
  /// If true, the person homes the device on request of the host: the grip moves fully out, then
  /// in, and back to the start.
  bool homes = false;
  std::uint64_t seed = 1;  ///< of the encoder offset at power-on
};

class PlantBody final : public Body {
 public:
  /// Throws std::invalid_argument if the start is beyond the reach.
  PlantBody(const PlantBodyOptions& options, const Hand& hand);

  void advance(double duration_s, const std::array<std::int16_t, 3>& words,
               bool homing) noexcept override;
  [[nodiscard]] DevicePacket present() const noexcept override;
  void lose_power() noexcept override;

  /// Advances with exact torques at the arms [N m] instead of words; they are neither rounded nor
  /// clamped.
  void advance_exactly(double duration_s, const Eigen::Vector3d& torque) noexcept;

  [[nodiscard]] const Plant& plant() const noexcept { return plant_; }
  [[nodiscard]] Hand& hand() noexcept { return hand_; }
  [[nodiscard]] const Hand& hand() const noexcept { return hand_; }
  /// Returns the present force of the motors on the hand [N].
  [[nodiscard]] Eigen::Vector3d delivered_force() const noexcept;
  /// Returns true if the supply or the motors' heat reduce the torques of the last words.
  [[nodiscard]] bool limited() const noexcept { return motors_.limited(); }
  [[nodiscard]] EnergyAudit energy() const noexcept { return plant_.energy(hand_); }

 private:
  void begin_gesture() noexcept;

  PlantBodyOptions options_;
  Kinematics kinematics_;
  Hand hand_;
  Intent gesture_;  ///< intent during homing; the person's own intent afterwards
  bool gestured_ = false;
  Plant plant_;
  Motors motors_;
  Encoders encoders_;
};

}  // namespace palpate::device::falcon
