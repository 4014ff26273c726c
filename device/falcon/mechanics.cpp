// SPDX-License-Identifier: MIT
#include "device/falcon/mechanics.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace palpate::device::falcon {

Mechanics::Mechanics(const Kinematics& kinematics, const PlantOptions& options)
    : kinematics_(kinematics),
      options_(options),
      inner_(std::cos(options.inner_stop), std::sin(options.inner_stop)),
      outer_(std::cos(options.outer_stop), std::sin(options.outer_stop)),
      widest_(kinematics.geometry().shin * std::sin(options.swing_stop)) {}

Eigen::Matrix3d Mechanics::inverse_mass(const Eigen::Matrix3d& slope,
                                        const Hand& hand) const noexcept {
  const Eigen::Matrix3d mass = grip_mass(hand) * Eigen::Matrix3d::Identity() +
                               options_.arm_inertia * slope.transpose() * slope;
  return mass.inverse();
}

/// A stop strained by `depth`, which grows at `rate`; it pushes back and never pulls.
void Mechanics::press(Stops& stops, double depth, double rate,
                      const Eigen::Vector3d& slope) const noexcept {
  if (depth <= 0.0) { return; }
  const double elastic = options_.stop_stiffness * depth;
  const double torque = std::max(0.0, elastic + options_.stop_viscosity * rate);
  stops.force -= torque * slope;
  stops.energy += 0.5 * elastic * depth;
  stops.loss += (torque - elastic) * rate;
}

/// Gradient of the angle between thigh and shin's projection [rad/m], from the law of cosines.
Eigen::Vector3d Mechanics::elbow_slope(int index, const Leg& leg,
                                       const Eigen::Vector3d& position) const noexcept {
  const Geometry& geometry = kinematics_.geometry();
  const LegFrame& frame = kinematics_.frame(index);
  const double a = geometry.thigh;
  const double L = leg.reach;
  const double X = leg.outward + a * leg.cosine;
  const double w = position.z();
  const double by_reach = (X * X + w * w - a * a + L * L) / (2.0 * a * L * L);
  Eigen::Vector3d of_cosine =
      X / (a * L) * frame.outward + by_reach * leg.sideways / leg.height * frame.sideways;
  of_cosine.z() += w / (a * L);
  return -of_cosine * (a * L / leg.lever);
}

Mechanics::Stops Mechanics::stops_at(const std::array<Leg, 3>& legs,
                                     const Eigen::Vector3d& position,
                                     const Eigen::Vector3d& velocity) const noexcept {
  Stops stops;
  const double a = kinematics_.geometry().thigh;
  for (int i = 0; i < 3; ++i) {
    const Leg& leg = legs[static_cast<std::size_t>(i)];
    const bool at_stop = leg.sine * outer_.x() > leg.cosine * outer_.y() ||
                         leg.sine * inner_.x() < leg.cosine * inner_.y();
    if (at_stop) {  // arc tangents are paid for only here
      const double theta1 = std::atan2(leg.sine, leg.cosine);
      const Eigen::Vector3d slope = leg.rate();
      const double rate = slope.dot(velocity);
      press(stops, theta1 - options_.outer_stop, rate, slope);
      press(stops, options_.inner_stop - theta1, -rate, -slope);
    }
    if (std::abs(leg.sideways) > widest_) {
      const double swing = std::atan2(leg.sideways, leg.height);
      const Eigen::Vector3d slope =
          std::copysign(1.0 / leg.height, swing) * kinematics_.frame(i).sideways;
      press(stops, std::abs(swing) - options_.swing_stop, slope.dot(velocity), slope);
    }
    const double along = leg.outward * leg.cosine + leg.away * leg.sine;  // L cos(elbow)
    if (along > 0.0 && leg.lever < a * leg.reach * options_.elbow_stop) {
      const Eigen::Vector3d slope = elbow_slope(i, leg, position);
      const double elbow = std::atan2(leg.lever / a, along);
      press(stops, options_.elbow_stop - elbow, -slope.dot(velocity), -slope);
    }
  }
  return stops;
}

Mechanics::Applied Mechanics::applied(const std::array<Leg, 3>& legs, const PlantState& state,
                                      const Drive& drive, const Hand& hand) const noexcept {
  const Eigen::Vector3d position = state.segment<3>(part::position);
  const Eigen::Vector3d velocity = state.segment<3>(part::velocity);
  const ArmMotion arm{.position = state.segment<3>(part::arm_position),
                      .velocity = state.segment<3>(part::arm_velocity)};
  Applied applied{.hand = hand_forces(hand, drive.intent, position, velocity, arm),
                  .stops = stops_at(legs, position, velocity)};
  const Eigen::Matrix3d slope = inverse_jacobian(legs);
  const Eigen::Vector3d rate = slope * velocity;
  for (int i = 0; i < 3; ++i) {
    applied.curvature[i] = curvature_acceleration(kinematics_.geometry(), kinematics_.frame(i),
                                                  legs[static_cast<std::size_t>(i)], velocity);
  }
  applied.motors = drive.torque.array() * (1.0 + drive.speed_share * rate.array());
  const Eigen::Vector3d at_arms =
      applied.motors - options_.viscosity * rate - options_.arm_inertia * applied.curvature;
  applied.force = applied.hand.on_grip + applied.stops.force + slope.transpose() * at_arms;
  applied.force.y() -= options_.gravity * (options_.effector_mass + options_.tool_mass);
  return applied;
}

bool Mechanics::evaluate(const PlantState& state, const Drive& drive, const Hand& hand,
                         const Slip& slip, Motion& motion) const noexcept {
  const Eigen::Vector3d velocity = state.segment<3>(part::velocity);
  const auto legs = kinematics_.legs(state.segment<3>(part::position));
  if (!legs) { return false; }
  const Eigen::Matrix3d slope = inverse_jacobian(*legs);
  const Applied given = applied(*legs, state, drive, hand);
  const Eigen::Matrix3d inverse = inverse_mass(slope, hand);
  motion.rate = slope * velocity;
  motion.arms = {.mobility = slope * inverse * slope.transpose(),
                 .free = slope * (inverse * given.force) + given.curvature};
  motion.friction = friction_torque(motion.arms, slip, options_.coulomb);
  const bool rests = slip[0] == 0 && slip[1] == 0 && slip[2] == 0;
  motion.derivative.segment<3>(part::position) = velocity;
  motion.derivative.segment<3>(part::velocity).setZero();  // exactly, when all arms are stuck
  if (!rests) {
    motion.derivative.segment<3>(part::velocity) =
        inverse * (given.force + slope.transpose() * motion.friction);
  }
  motion.derivative.segment<3>(part::arm_position) = state.segment<3>(part::arm_velocity);
  motion.derivative.segment<3>(part::arm_velocity) =
      given.hand.on_arm / (hand.arm ? hand.arm->mass : 1.0);
  motion.derivative[part::friction_loss] =
      options_.viscosity * motion.rate.squaredNorm() - motion.friction.dot(motion.rate);
  motion.derivative[part::stop_loss] = given.stops.loss;
  motion.derivative[part::motor_work] = given.motors.dot(motion.rate);
  motion.derivative[part::hand_work] = given.hand.on_grip.dot(velocity);
  return true;
}

Eigen::Vector3d Mechanics::held(const PlantState& state, const Hand& hand,
                                const Slip& slip) const noexcept {
  const Eigen::Vector3d velocity = state.segment<3>(part::velocity);
  const auto legs = kinematics_.legs(state.segment<3>(part::position));
  const bool rests = slip[0] == 0 && slip[1] == 0 && slip[2] == 0;
  if (rests || !legs) { return Eigen::Vector3d::Zero(); }
  if (slip[0] != 0 && slip[1] != 0 && slip[2] != 0) { return velocity; }
  const Eigen::Matrix3d slope = inverse_jacobian(*legs);
  const Eigen::Matrix3d inverse = inverse_mass(slope, hand);
  // Impulses on the stuck arms alone: friction without a limit.
  const ArmDynamics arms{.mobility = slope * inverse * slope.transpose(), .free = slope * velocity};
  return velocity + inverse * (slope.transpose() * friction_torque(arms, slip, 0.0));
}

double Mechanics::kinetic(const PlantState& state, const Hand& hand) const noexcept {
  const Eigen::Vector3d velocity = state.segment<3>(part::velocity);
  const auto legs = kinematics_.legs(state.segment<3>(part::position));
  const double arms = legs ? (inverse_jacobian(*legs) * velocity).squaredNorm() : 0.0;
  return 0.5 * (grip_mass(hand) * velocity.squaredNorm() + options_.arm_inertia * arms);
}

double Mechanics::potential(const PlantState& state) const noexcept {
  const Eigen::Vector3d position = state.segment<3>(part::position);
  const auto legs = kinematics_.legs(position);
  const double stops = legs ? stops_at(*legs, position, Eigen::Vector3d::Zero()).energy : 0.0;
  return options_.gravity * (options_.effector_mass + options_.tool_mass) * position.y() + stops;
}

}  // namespace palpate::device::falcon
