// SPDX-License-Identifier: MIT
#include "device/falcon/plant.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::device::falcon {
namespace {

constexpr int most_events = 12;           // in one substep; then its rest is taken as it comes
constexpr double event_accuracy = 1e-12;  // of the step
constexpr double least_margin = 1e-13;    // [rad/s], [N m]: below it an arm sticks, or slips

int sign_of(double value) noexcept { return value > 0.0 ? 1 : value < 0.0 ? -1 : 0; }

}  // namespace

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
  energy_at_start_ = mechanics_.kinetic(state_, hand) + mechanics_.potential(state_);
  return true;
}

Drive Plant::drive_at(const Given& given, double time) noexcept {
  return {.torque = given.motors.torque_after(time - given.begin),
          .speed_share = given.motors.speed_share(),
          .intent = given.hand.intent.at(time)};
}

void Plant::settle(const Given& given) noexcept {
  Motion motion;
  if (!mechanics_.evaluate(state_, drive_at(given, time_), given.hand, slip_, motion)) { return; }
  slip_ = settled(motion.arms, slip_, mechanics_.options().coulomb);
}

/// One step of order 4 from the state, with the slip as it is; false when it leaves the reach.
bool Plant::trial(const Given& given, double h, PlantState& end) const noexcept {
  Motion k1, k2, k3, k4;
  const Drive middle = drive_at(given, time_ + 0.5 * h);
  const Hand& hand = given.hand;
  const bool within =
      mechanics_.evaluate(state_, drive_at(given, time_), hand, slip_, k1) &&
      mechanics_.evaluate(state_ + 0.5 * h * k1.derivative, middle, hand, slip_, k2) &&
      mechanics_.evaluate(state_ + 0.5 * h * k2.derivative, middle, hand, slip_, k3) &&
      mechanics_.evaluate(state_ + h * k3.derivative, drive_at(given, time_ + h), hand, slip_, k4);
  if (!within) { return false; }
  end = state_ +
        h / 6.0 * (k1.derivative + 2.0 * k2.derivative + 2.0 * k3.derivative + k4.derivative);
  const Eigen::Vector3d position = end.segment<3>(part::position);
  return end.allFinite() && mechanics_.kinematics().legs(position).has_value();
}

double Plant::lawfulness(const Given& given, const PlantState& state, double time,
                         Slip& broken) const noexcept {
  Motion motion;
  if (!mechanics_.evaluate(state, drive_at(given, time), given.hand, slip_, motion)) {
    return -1.0;
  }
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

/// Time from now [s] at which the first arm sticks or slips; it happens within the duration. The
/// rule of false position, with the stale end's value halved.
double Plant::next_event(const Given& given, double duration, double at_end) const noexcept {
  Slip broken{};
  double low = 0.0;
  double high = duration;
  double at_low = lawfulness(given, state_, time_, broken);
  double at_high = at_end;
  if (!(at_low > least_margin)) {  // it has just begun to slide
    low = 1e-6 * duration;
    PlantState state;
    if (!trial(given, low, state)) { return 0.0; }
    at_low = lawfulness(given, state, time_ + low, broken);
    if (!(at_low > least_margin)) { return low; }
  }
  int side = 0;
  for (int n = 0; n < 60 && high - low > event_accuracy * duration; ++n) {
    const double middle = (low * at_high - high * at_low) / (at_high - at_low);
    PlantState state;
    if (!(middle > low) || !(middle < high) || !trial(given, middle, state)) { break; }
    const double value = lawfulness(given, state, time_ + middle, broken);
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
  return high;  // at or just past it
}

void Plant::accept(const Given& given, const PlantState& state, double duration) noexcept {
  state_ = state;
  time_ += duration;
  if (slip_[0] == 0 || slip_[1] == 0 || slip_[2] == 0) {  // rounding only, a drift over hours
    state_.segment<3>(part::velocity) = mechanics_.held(state_, given.hand, slip_);
  }
}

/// The stops have been overrun: the mechanism comes to rest where it is, and loses its energy.
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
    PlantState end;
    if (!trial(given, left, end)) { return halt(given, left); }
    Slip broken{};
    double least = lawfulness(given, end, end_time, broken);
    double taken = left;
    if (least < least_margin && event < most_events) {
      taken = next_event(given, left, least);
      if (!trial(given, taken, end)) { return halt(given, left); }
      least = lawfulness(given, end, time_ + taken, broken);
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
  settle(given);  // the words have changed since
  const double begin = time_;
  const double steps = std::max(1.0, std::ceil(duration / mechanics_.options().substep - 1e-6));
  for (double n = 1.0; n <= steps; n += 1.0) {
    substep(given, begin + duration * (n / steps) - time_);
  }
  time_ = begin + duration;
  motors.advance(duration);
}

Eigen::Vector3d Plant::theta1() const noexcept {
  const auto angles = mechanics_.kinematics().inverse(position());
  return angles ? angles->theta1 : Eigen::Vector3d::Zero();
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

}  // namespace palpate::device::falcon
