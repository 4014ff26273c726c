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
  now_known_ = false;
  energy_at_start_ = mechanics_.kinetic(state_, hand) + mechanics_.potential(state_);
  return true;
}

Drive Plant::drive_at(const Given& given, double time) noexcept {
  return {.torque = given.motors.torque_after(time - given.begin),
          .speed_share = given.motors.speed_share(),
          .intent = given.hand.intent.at(time)};
}

void Plant::settle(const Given& given) noexcept {
  now_known_ = mechanics_.evaluate(state_, drive_at(given, time_), given.hand, slip_, now_);
  if (!now_known_) { return; }
  const Slip slip = settled(now_.arms, slip_, mechanics_.options().coulomb);
  now_known_ = slip == slip_;  // else it moves otherwise than it was looked at
  slip_ = slip;
}

bool Plant::look(const Given& given) noexcept {
  now_known_ =
      now_known_ || mechanics_.evaluate(state_, drive_at(given, time_), given.hand, slip_, now_);
  return now_known_;
}

/// One step of order 4 from the state, which was looked at, with the slip as it is; false when it leaves
/// the reach.
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
  end.state = state_ + h / 6.0 * (now_.derivative + 2.0 * k2.derivative + 2.0 * k3.derivative +
                                  k4.derivative);
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

/// Time from now [s] at which the first arm sticks or slips; it happens within the duration. The
/// rule of false position, with the stale end's value halved.
double Plant::next_event(const Given& given, double duration, double at_end) const noexcept {
  Slip broken{};
  double low = 0.0;
  double high = duration;
  double at_low = lawfulness(now_, broken);
  double at_high = at_end;
  if (!(at_low > least_margin)) {  // it has just begun to slide
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
  return high;  // at or just past it
}

void Plant::accept(const Given& given, const Reached& end, double duration) noexcept {
  state_ = end.state;
  now_ = end.motion;
  time_ += duration;
  if (slip_[0] == 0 || slip_[1] == 0 || slip_[2] == 0) {  // rounding only, a drift over hours
    state_.segment<3>(part::velocity) = mechanics_.held(state_, given.hand, slip_);
    now_known_ = false;
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

}  // namespace palpate::device::falcon
