// SPDX-License-Identifier: MIT
#include "device/falcon/driver_profile.hpp"

#include <Eigen/LU>
#include <cmath>

namespace palpate::device::falcon {
namespace {

constexpr double most_torque = 30.0;   // [N m] where libnifalcon scales down; never reached
constexpr double close_enough = 0.01;  // [rad]
constexpr int most_tries = 15;

}  // namespace

Eigen::Vector3d CorrectProfile::position(const Counts& counts) noexcept {
  const Eigen::Vector3d theta1 = angles_of_counts(kinematics_.geometry(), counts);
  position_ = kinematics_.forward(theta1, position_).value_or(position_);
  return position_;
}

Command CorrectProfile::words(const Eigen::Vector3d& position,
                              const Eigen::Vector3d& force_on_hand) noexcept {
  const auto jacobian = kinematics_.jacobian(position);
  if (!jacobian) { return {}; }
  return words_of_torque(motors_, torque_of_force(*jacobian, force_on_hand));
}

std::optional<Eigen::Matrix3d> stock_jacobian(const Kinematics& kinematics,
                                              const Eigen::Vector3d& position) noexcept {
  const auto legs = kinematics.legs(position);
  if (!legs) { return std::nullopt; }
  Eigen::Matrix3d rates = inverse_jacobian(*legs);
  for (int i = 0; i < 3; ++i) {
    const Leg& leg = (*legs)[static_cast<std::size_t>(i)];
    const double sine_theta2 = leg.away / leg.reach;
    const double sine_theta3 = leg.height / kinematics.geometry().shin;
    rates(i, 2) *= sine_theta2 / sine_theta3;
  }
  return rates.inverse();
}

Eigen::Vector3d StockProfile::position(const Counts& counts) noexcept {
  const Eigen::Vector3d wanted = angles_of_counts(kinematics_.geometry(), counts);
  Eigen::Vector3d guess = position_;
  double share = 0.5;
  double error_before = HUGE_VAL;
  for (int n = 0; n < most_tries; ++n) {
    const auto angles = kinematics_.inverse(guess);
    const auto jacobian = stock_jacobian(kinematics_, guess);
    if (!angles || !jacobian) { break; }
    const Eigen::Vector3d miss = wanted - angles->theta1;
    guess += share * (*jacobian * miss);
    const double error = miss.norm();
    if (error < close_enough) {  // of the guess before the step
      position_ = guess;
      break;
    }
    if (error > error_before) { share *= 0.5; }
    error_before = error;
  }
  return position_;
}

Command StockProfile::words(const Eigen::Vector3d& position,
                            const Eigen::Vector3d& force_on_hand) noexcept {
  const auto jacobian = stock_jacobian(kinematics_, position);
  if (!jacobian) { return {}; }
  Eigen::Vector3d torque = torque_of_force(*jacobian, force_on_hand);
  const double largest = torque.cwiseAbs().maxCoeff();
  if (largest > most_torque) { torque *= most_torque / largest; }
  const MotorOptions uncalibrated{.words_per_newton_metre = libnifalcon_scale};
  Command command{.asked = words_of_torque(uncalibrated, torque).asked};
  for (std::size_t leg = 0; leg < 3; ++leg) { command.sent[leg] = wrapped(command.asked[leg]); }
  return command;
}

}  // namespace palpate::device::falcon
