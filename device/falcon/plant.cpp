// SPDX-License-Identifier: MIT

#include "device/falcon/plant.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace palpate::device::falcon {
namespace {

constexpr double rounding = 1e-12;  // relative to the limit and to the largest acceleration

/// Returns true if the slip of the arms that were at rest satisfies the friction law.
bool lawful(const ArmDynamics& arms, const Slip& before, const Slip& slip, double limit) noexcept {
  const Eigen::Vector3d torque = friction_torque(arms, slip, limit);
  const Eigen::Vector3d acceleration = arms.free + arms.mobility * torque;
  const double scale =
      arms.free.cwiseAbs().maxCoeff() + limit * arms.mobility.diagonal().maxCoeff();
  for (std::size_t leg = 0; leg < 3; ++leg) {
    const auto i = static_cast<Eigen::Index>(leg);
    if (before[leg] != 0) { continue; }
    const bool holds = slip[leg] == 0 ? std::abs(torque[i]) <= limit * (1.0 + rounding)
                                      : slip[leg] * acceleration[i] >= -rounding * scale;
    if (!holds) { return false; }
  }
  return true;
}

constexpr int most_events = 12;           // per substep; its rest then has no events
constexpr double event_accuracy = 1e-12;  // of the step
constexpr double least_margin = 1e-13;    // below it an arm sticks or slips [rad/s], [N m]

int sign_of(double value) noexcept { return value > 0.0 ? 1 : value < 0.0 ? -1 : 0; }

/// Returns the homing motion: out until every arm is beyond its arming angle, in past the index
/// marks, and back.
Intent homing_gesture(const Eigen::Vector3d& start) {
  constexpr double out = 0.174;  // z [m]: theta1 is 72 degrees on the axis
  constexpr double in = 0.105;   // 12 degrees
  constexpr double speed = 0.15;
  constexpr double ramp = 0.1;
  IntentScript script{.start = start};
  const double outmost = std::max(out, start.z());
  if (outmost > start.z()) {
    script.actions.emplace_back(
        Withdraw{.distance = outmost - start.z(), .speed = speed, .ramp = ramp});
  }
  script.actions.emplace_back(Hold{.duration = 0.2});
  script.actions.emplace_back(Advance{.distance = outmost - in, .speed = speed, .ramp = ramp});
  script.actions.emplace_back(Hold{.duration = 0.2});
  if (start.z() > in) {
    script.actions.emplace_back(Withdraw{.distance = start.z() - in, .speed = speed, .ramp = ramp});
  }
  return Intent(script);
}

}  // namespace

Eigen::Vector3d friction_torque(const ArmDynamics& arms, const Slip& slip, double limit) noexcept {
  Eigen::Vector3d torque;
  for (int i = 0; i < 3; ++i) { torque[i] = -limit * slip[static_cast<std::size_t>(i)]; }
  if (slip[0] != 0 && slip[1] != 0 && slip[2] != 0) { return torque; }
  const Eigen::Vector3d sliding = arms.free + arms.mobility * torque;
  Eigen::Matrix3d held = Eigen::Matrix3d::Identity();
  Eigen::Vector3d wanted = torque;
  for (int i = 0; i < 3; ++i) {
    if (slip[static_cast<std::size_t>(i)] != 0) { continue; }
    for (int j = 0; j < 3; ++j) {
      held(i, j) = slip[static_cast<std::size_t>(j)] == 0 ? arms.mobility(i, j) : 0.0;
    }
    wanted[i] = -sliding[i];
  }
  return held.inverse() * wanted;
}

Slip settled(const ArmDynamics& arms, const Slip& slip, double limit) noexcept {
  constexpr std::array<int, 3> choices{0, 1, -1};  // stuck is tried first
  for (int code = 0; code < 27; ++code) {
    Slip trial = slip;
    bool repeated = false;
    for (std::size_t leg = 0, digits = static_cast<std::size_t>(code); leg < 3;
         ++leg, digits /= 3) {
      const bool free_to_choose = slip[leg] == 0;
      repeated = repeated || (!free_to_choose && digits % 3 != 0);
      if (free_to_choose) { trial[leg] = choices[digits % 3]; }
    }
    if (!repeated && lawful(arms, slip, trial, limit)) { return trial; }
  }
  return slip;
}

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

/// Adds the force of a stop with penetration `depth`, which grows at `rate`; a stop never pulls.
void Mechanics::press(Stops& stops, double depth, double rate,
                      const Eigen::Vector3d& slope) const noexcept {
  if (depth <= 0.0) { return; }
  const double elastic = options_.stop_stiffness * depth;
  const double torque = std::max(0.0, elastic + options_.stop_viscosity * rate);
  stops.force -= torque * slope;
  stops.energy += 0.5 * elastic * depth;
  stops.loss += (torque - elastic) * rate;
}

/// Returns the gradient of the angle between thigh and projected shin [rad/m], from the law of
/// cosines.
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
    if (at_stop) {  // arc tangents are expensive and needed only here
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

bool Mechanics::evaluate(const PlantState& state, const Drive& drive, const Hand& hand,
                         const Slip& slip, Motion& motion) const noexcept {
  const Eigen::Vector3d position = state.segment<3>(part::position);
  const Eigen::Vector3d velocity = state.segment<3>(part::velocity);
  const auto legs = kinematics_.legs(position);
  if (!legs) { return false; }
  const ArmMotion arm{.position = state.segment<3>(part::arm_position),
                      .velocity = state.segment<3>(part::arm_velocity)};
  const HandForces by_hand = hand_forces(hand, drive.intent, position, velocity, arm);
  const Stops stops = stops_at(*legs, position, velocity);
  const Eigen::Matrix3d slope = inverse_jacobian(*legs);
  motion.rate = slope * velocity;
  Eigen::Vector3d curvature;  // acceleration of the arms at constant velocity [rad/s^2]
  for (int i = 0; i < 3; ++i) {
    curvature[i] = curvature_acceleration(kinematics_.geometry(), kinematics_.frame(i),
                                          (*legs)[static_cast<std::size_t>(i)], velocity);
  }
  const Eigen::Vector3d at_arms =
      drive.torque - options_.viscosity * motion.rate - options_.arm_inertia * curvature;
  Eigen::Vector3d force = by_hand.on_grip + stops.force + slope.transpose() * at_arms;
  force.y() -= options_.gravity * (options_.effector_mass + options_.tool_mass);
  const Eigen::Matrix3d inverse = inverse_mass(slope, hand);
  motion.arms = {.mobility = slope * inverse * slope.transpose(),
                 .free = slope * (inverse * force) + curvature};
  motion.friction = friction_torque(motion.arms, slip, options_.coulomb);
  const bool rests = slip[0] == 0 && slip[1] == 0 && slip[2] == 0;
  motion.derivative.segment<3>(part::position) = velocity;
  motion.derivative.segment<3>(part::velocity).setZero();  // exactly, when all arms are stuck
  if (!rests) {
    motion.derivative.segment<3>(part::velocity) =
        inverse * (force + slope.transpose() * motion.friction);
  }
  motion.derivative.segment<3>(part::arm_position) = state.segment<3>(part::arm_velocity);
  motion.derivative.segment<3>(part::arm_velocity) =
      by_hand.on_arm / (hand.arm ? hand.arm->mass : 1.0);
  motion.derivative[part::friction_loss] =
      options_.viscosity * motion.rate.squaredNorm() - motion.friction.dot(motion.rate);
  motion.derivative[part::stop_loss] = stops.loss;
  motion.derivative[part::motor_work] = drive.torque.dot(motion.rate);
  motion.derivative[part::hand_work] = by_hand.on_grip.dot(velocity);
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
  // Impulses on the stuck arms alone, which is friction without a limit.
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

Plant::Plant(const Kinematics& kinematics, const PlantOptions& options)
    : mechanics_(kinematics, options) {
  place(Kinematics::centre(), Hand{.impedance = no_hand});
}

bool Plant::place(const Eigen::Vector3d& position, const Hand& hand,
                  const Eigen::Vector3d& velocity) noexcept {
  const auto legs = mechanics_.kinematics().legs(position);
  if (!legs) { return false; }
  state_.setZero();
  state_.segment<3>(part::position) = position;
  state_.segment<3>(part::velocity) = velocity;
  const Eigen::Vector3d rate = inverse_jacobian(*legs) * velocity;
  slip_ = {sign_of(rate[0]), sign_of(rate[1]), sign_of(rate[2])};
  arm_placed_ = false;
  now_known_ = false;
  energy_at_start_ = mechanics_.kinetic(state_, hand) + mechanics_.potential(state_);
  return true;
}

Drive Plant::drive_at(const Given& given, double time) noexcept {
  return {.torque = given.motors.torque_after(time - given.begin),
          .intent = given.hand.intent.at(time)};
}

void Plant::settle(const Given& given) noexcept {
  now_known_ = mechanics_.evaluate(state_, drive_at(given, time_), given.hand, slip_, now_);
  if (!now_known_) { return; }
  const Slip slip = settled(now_.arms, slip_, mechanics_.options().coulomb);
  now_known_ = slip == slip_;  // otherwise the motion differs from the evaluated one
  slip_ = slip;
}

bool Plant::look(const Given& given) noexcept {
  now_known_ =
      now_known_ || mechanics_.evaluate(state_, drive_at(given, time_), given.hand, slip_, now_);
  return now_known_;
}

/// Takes one step of order 4 from the evaluated state with the present slip. Returns false if the
/// step leaves the reach.
bool Plant::trial(const Given& given, double h, Reached& end) const noexcept {
  Motion k2, k3, k4;
  const Drive middle = drive_at(given, time_ + 0.5 * h);
  const Drive last = drive_at(given, time_ + h);
  const Hand& hand = given.hand;
  const bool within =
      mechanics_.evaluate(state_ + 0.5 * h * now_.derivative, middle, hand, slip_, k2) &&
      mechanics_.evaluate(state_ + 0.5 * h * k2.derivative, middle, hand, slip_, k3) &&
      mechanics_.evaluate(state_ + h * k3.derivative, last, hand, slip_, k4);
  if (!within) { return false; }
  end.state =
      state_ +
      h / 6.0 * (now_.derivative + 2.0 * k2.derivative + 2.0 * k3.derivative + k4.derivative);
  return end.state.allFinite() && mechanics_.evaluate(end.state, last, hand, slip_, end.motion);
}

double Plant::lawfulness(const Motion& motion, Slip& broken) const noexcept {
  const double limit = mechanics_.options().coulomb;
  double least = 1.0;
  for (std::size_t leg = 0; leg < 3; ++leg) {
    const auto i = static_cast<Eigen::Index>(leg);
    const double margin = slip_[leg] != 0 ? slip_[leg] * motion.rate[i]
                                          : limit * (1.0 + 1e-9) - std::abs(motion.friction[i]);
    broken[leg] = margin < least_margin ? 1 : 0;
    least = std::min(least, margin);
  }
  return least;
}

/// Returns the time from now [s] at which the first arm sticks or slips, within the duration. It
/// uses the Illinois variant of the false position method.
double Plant::next_event(const Given& given, double duration, double at_end) const noexcept {
  Slip broken{};
  double low = 0.0;
  double high = duration;
  double at_low = lawfulness(now_, broken);
  double at_high = at_end;
  if (!(at_low > least_margin)) {  // it has just started to slide
    low = 1e-6 * duration;
    Reached reached;
    if (!trial(given, low, reached)) { return 0.0; }
    at_low = lawfulness(reached.motion, broken);
    if (!(at_low > least_margin)) { return low; }
  }
  int side = 0;
  for (int n = 0; n < 60 && high - low > event_accuracy * duration; ++n) {
    const double middle = (low * at_high - high * at_low) / (at_high - at_low);
    Reached reached;
    if (!(middle > low) || !(middle < high) || !trial(given, middle, reached)) { break; }
    const double value = lawfulness(reached.motion, broken);
    if (value > least_margin) {
      low = middle;
      at_low = value;
      if (side == 1) { at_high *= 0.5; }
      side = 1;
    } else {
      high = middle;
      at_high = value;
      if (side == -1) { at_low *= 0.5; }
      side = -1;
    }
  }
  return high;  // at the event or just after it
}

void Plant::accept(const Given& given, const Reached& end, double duration) noexcept {
  state_ = end.state;
  now_ = end.motion;
  time_ += duration;
  if (slip_[0] == 0 || slip_[1] == 0 || slip_[2] == 0) {  // corrects rounding drift
    state_.segment<3>(part::velocity) = mechanics_.held(state_, given.hand, slip_);
    now_known_ = false;
  }
}

/// Stops the mechanism after it has overrun the stops; its kinetic energy is dissipated.
void Plant::halt(const Given& given, double duration) noexcept {
  state_[part::stop_loss] += mechanics_.kinetic(state_, given.hand);
  state_.segment<3>(part::velocity).setZero();
  slip_ = {};
  time_ += duration;
  ++halts_;
  settle(given);
}

void Plant::substep(const Given& given, double duration) noexcept {
  const double end_time = time_ + duration;
  for (int event = 0; event <= most_events; ++event) {
    const double left = end_time - time_;
    Reached end;
    if (!look(given) || !trial(given, left, end)) { return halt(given, left); }
    Slip broken{};
    double least = lawfulness(end.motion, broken);
    double taken = left;
    if (least < least_margin && event < most_events) {
      taken = next_event(given, left, least);
      if (!trial(given, taken, end)) { return halt(given, left); }
      least = lawfulness(end.motion, broken);
    }
    accept(given, end, taken);
    if (taken == left && least >= least_margin) { return; }
    for (std::size_t leg = 0; leg < 3; ++leg) { slip_[leg] *= 1 - broken[leg]; }
    state_.segment<3>(part::velocity) = mechanics_.held(state_, given.hand, slip_);
    settle(given);
    if (!(time_ < end_time)) { return; }
  }
}

void Plant::advance(double duration, Motors& motors, const Hand& hand) noexcept {
  const Given given{.motors = motors, .hand = hand, .begin = time_};
  if (hand.arm && !arm_placed_) {
    state_.segment<3>(part::arm_position) = hand.intent.at(time_).position;
    arm_placed_ = true;
  }
  settle(given);  // the words may have changed
  const double begin = time_;
  const double steps = std::max(1.0, std::ceil(duration / mechanics_.options().substep - 1e-6));
  for (double n = 1.0; n <= steps; n += 1.0) {
    substep(given, begin + duration * (n / steps) - time_);
  }
  time_ = begin + duration;
  motors.advance(duration);
}

Eigen::Vector3d Plant::theta1() const noexcept {
  const auto legs = mechanics_.kinematics().legs(position());
  return legs ? angles_at_base(*legs) : Eigen::Vector3d::Zero();
}

EnergyAudit Plant::energy(const Hand& hand) const noexcept {
  return {.kinetic = mechanics_.kinetic(state_, hand),
          .potential = mechanics_.potential(state_),
          .friction_loss = state_[part::friction_loss],
          .stop_loss = state_[part::stop_loss],
          .motor_work = state_[part::motor_work],
          .hand_work = state_[part::hand_work],
          .at_start = energy_at_start_};
}

PlantBody::PlantBody(const PlantBodyOptions& options, const Hand& hand)
    : options_(options),
      kinematics_(options.geometry),
      hand_(hand),
      gesture_(homing_gesture(options.start)),
      plant_(kinematics_, options.plant),
      motors_(options.motors),
      encoders_(options.geometry, options.encoders, options.seed) {
  if (!plant_.place(options.start, hand_)) {
    throw std::invalid_argument("the grip's start is beyond the device's reach");
  }
  if (options.homed) { encoders_.home(); }
  encoders_.sample(plant_.theta1(), false);
}

void PlantBody::advance(double duration_s, const std::array<std::int16_t, 3>& words,
                        bool homing) noexcept {
  if (homing && options_.homes && !gestured_ && !encoders_.all_homed()) { begin_gesture(); }
  motors_.command(words);
  plant_.advance(duration_s, motors_, hand_);
  encoders_.sample(plant_.theta1(), homing);
}

void PlantBody::advance_exactly(double duration_s, const Eigen::Vector3d& torque) noexcept {
  motors_.command_torque(torque);
  plant_.advance(duration_s, motors_, hand_);
  encoders_.sample(plant_.theta1(), false);
}

void PlantBody::begin_gesture() noexcept {
  gesture_.delay(plant_.time());
  std::swap(hand_.intent, gesture_);
  gestured_ = true;
}

DevicePacket PlantBody::present() const noexcept {
  return {.counts = encoders_.counts(), .homed = encoders_.homed()};
}

/// Simulates a power cycle: the counters get new arbitrary offsets and the grip keeps its position.
void PlantBody::lose_power() noexcept {
  encoders_ = Encoders(options_.geometry, options_.encoders, ++options_.seed);
  encoders_.sample(plant_.theta1(), false);
  gestured_ = false;
}

Eigen::Vector3d PlantBody::delivered_force() const noexcept {
  const auto legs = kinematics_.legs(plant_.position());
  if (!legs) { return Eigen::Vector3d::Zero(); }
  return force_of_torque(jacobian(*legs), motors_.torque_after(0.0));
}

}  // namespace palpate::device::falcon
