// SPDX-License-Identifier: MIT
#pragma once
/// The emulated mechanism, moving (device/README.md, "Motion"): classical Runge-Kutta of order 4
/// between the instants at which an arm sticks or slips, which are found to 1e-12 of a step. The
/// same bits for the same calls; no allocation, no lock.

#include "device/falcon/mechanics.hpp"
#include "device/falcon/motors.hpp"

namespace palpate::device::falcon {

/// Since the plant was placed [J]. What is lost counts positive.
struct EnergyAudit {
  double kinetic = 0.0;    ///< effector, tool, arms, and the hand's mass at the grip
  double potential = 0.0;  ///< height and strained stops
  double friction_loss = 0.0;
  double stop_loss = 0.0;
  double motor_work = 0.0;  ///< on the mechanism
  double hand_work = 0.0;   ///< of the hand's springs and dampers on the grip
  double at_start = 0.0;    ///< kinetic + potential, then
  /// What the integrator gained: 0 but for its error.
  [[nodiscard]] double imbalance() const {
    return kinetic + potential - at_start + friction_loss + stop_loss - motor_work - hand_work;
  }
};

class Plant {
 public:
  explicit Plant(const Kinematics& kinematics = Kinematics(), const PlantOptions& options = {});

  /// Moves the grip there, with this velocity, and begins the audit again. Nothing happens and
  /// false comes back when the position is beyond reach.
  bool place(const Eigen::Vector3d& position, const Hand& hand,
             const Eigen::Vector3d& velocity = Eigen::Vector3d::Zero()) noexcept;

  /// `duration` seconds on, with the motors on their way to their last words.
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
  /// Substeps that would have left the reach and ended at rest instead.
  [[nodiscard]] long halts() const noexcept { return halts_; }
  [[nodiscard]] EnergyAudit energy(const Hand& hand) const noexcept;
  [[nodiscard]] const Mechanics& mechanics() const noexcept { return mechanics_; }

 private:
  struct Given {
    const Motors& motors;
    const Hand& hand;
    double begin = 0.0;  ///< of this call [s]
  };
  [[nodiscard]] static Drive drive_at(const Given& given, double time) noexcept;
  struct Reached {
    PlantState state;
    Motion motion;  ///< there
  };
  void settle(const Given& given) noexcept;
  /// Motion at the present state; false beyond reach.
  bool look(const Given& given) noexcept;
  bool trial(const Given& given, double duration, Reached& end) const noexcept;
  /// Least of what must stay positive while the slip is what it is.
  double lawfulness(const Motion& motion, Slip& broken) const noexcept;
  double next_event(const Given& given, double duration, double at_end) const noexcept;
  void substep(const Given& given, double duration) noexcept;
  void accept(const Given& given, const Reached& end, double duration) noexcept;
  void halt(const Given& given, double duration) noexcept;

  Mechanics mechanics_;
  PlantState state_ = PlantState::Zero();
  Motion now_{};             ///< at the state, while it is known
  bool now_known_ = false;
  Slip slip_{};
  double time_ = 0.0;
  double energy_at_start_ = 0.0;
  long halts_ = 0;
  bool arm_placed_ = false;
};

}  // namespace palpate::device::falcon
