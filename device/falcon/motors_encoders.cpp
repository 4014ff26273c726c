// SPDX-License-Identifier: MIT

#include "device/falcon/motors_encoders.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "device/seeded.hpp"

namespace palpate::device::falcon {

Command words_of_torque(const MotorOptions& options, const Eigen::Vector3d& torque) noexcept {
  constexpr double most = 1e15;  // far beyond any word, well within the integer
  Command command;
  for (std::size_t leg = 0; leg < 3; ++leg) {
    const double exact = -options.words_per_newton_metre * torque[static_cast<Eigen::Index>(leg)];
    const double bounded = std::isnan(exact) ? 0.0 : std::clamp(exact, -most, most);
    command.asked[leg] = static_cast<std::int64_t>(bounded);
    const std::int64_t limit = options.largest_word;
    const std::int64_t word = std::clamp(command.asked[leg], -limit, limit);
    command.saturated = command.saturated || word != command.asked[leg];
    command.sent[leg] = static_cast<std::int16_t>(word);
  }
  return command;
}

Eigen::Vector3d torque_of_words(const MotorOptions& options, const Words& words) noexcept {
  Eigen::Vector3d torque;
  for (std::size_t leg = 0; leg < 3; ++leg) {
    const int word = std::clamp<int>(words[leg], -options.largest_word, options.largest_word);
    torque[static_cast<Eigen::Index>(leg)] = -word / options.words_per_newton_metre;
  }
  return torque;
}

double largest_torque(const MotorOptions& options) noexcept {
  return options.largest_word / options.words_per_newton_metre;
}

namespace {

/// Power of each motor [W]: that of a current through a resistance.
Eigen::Vector3d power_of(const MotorOptions& options, const Eigen::Vector3d& torque) noexcept {
  return options.largest_power * (torque / largest_torque(options)).cwiseAbs2();
}

/// Returns the length of the vector of torques that takes the whole power of the supply [N m].
double torque_of_supply(const MotorOptions& options) noexcept {
  return largest_torque(options) * std::sqrt(options.supply_power / options.largest_power);
}

}  // namespace

Eigen::Vector3d supplied(const MotorOptions& options, const Eigen::Vector3d& torque) noexcept {
  return torque * std::min(1.0, torque_of_supply(options) / torque.norm());
}

double largest_force(const MotorOptions& options, const Eigen::Matrix3d& jacobian,
                     const Eigen::Vector3d& direction) noexcept {
  return std::min(largest_force(jacobian, direction, largest_torque(options)),
                  torque_of_supply(options) / (jacobian.transpose() * direction).norm());
}

double weakest_force(const MotorOptions& options, const Eigen::Matrix3d& jacobian) noexcept {
  const double longest = std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(
                                       jacobian * jacobian.transpose(), Eigen::EigenvaluesOnly)
                                       .eigenvalues()
                                       .maxCoeff());
  return std::min(weakest_direction(jacobian, largest_torque(options)).force,
                  torque_of_supply(options) / longest);
}

Eigen::Vector3d Motors::cooled(const Eigen::Vector3d& torque) const noexcept {
  if (options_.thermal_time <= 0.0) { return torque; }
  Eigen::Vector3d result = torque;
  for (int leg = 0; leg < 3; ++leg) {
    const double folded =
        std::clamp(5.0 * (heat_(leg) / options_.continuous_power - 0.8), 0.0, 1.0);
    const double power = options_.largest_power +
                         folded * std::min(0.0, options_.continuous_power - options_.largest_power);
    const double most = largest_torque(options_) * std::sqrt(power / options_.largest_power);
    result(leg) = std::clamp(torque(leg), -most, most);
  }
  return result;
}

void Motors::command(const Words& words) noexcept {
  const Eigen::Vector3d wanted = torque_of_words(options_, words);
  target_ = supplied(options_, cooled(wanted));
  limited_ = target_ != wanted;
}

void Motors::advance(double duration) noexcept {
  torque_ = torque_after(duration);
  if (options_.thermal_time <= 0.0) { return; }
  heat_ += (power_of(options_, torque_) - heat_) * -std::expm1(-duration / options_.thermal_time);
}

Eigen::Vector3d Motors::torque_after(double duration) const noexcept {
  if (options_.time_constant <= 0.0) { return target_; }
  return target_ + (torque_ - target_) * std::exp(-duration / options_.time_constant);
}

std::int64_t counts_of_angle(const Geometry& geometry, double theta1) noexcept {
  const double exact = (theta1 - geometry.zero_angle) * geometry.counts_per_radian();
  return static_cast<std::int64_t>(std::round(exact));
}

std::int16_t wrapped(std::int64_t value) noexcept {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(value));
}

Counts counts_of_angles(const Geometry& geometry, const Eigen::Vector3d& theta1) noexcept {
  return {wrapped(counts_of_angle(geometry, theta1[0])),
          wrapped(counts_of_angle(geometry, theta1[1])),
          wrapped(counts_of_angle(geometry, theta1[2]))};
}

Eigen::Vector3d angles_of_counts(const Geometry& geometry, const Counts& counts) noexcept {
  const Eigen::Vector3d from_mark(counts[0], counts[1], counts[2]);
  return (from_mark / geometry.counts_per_radian()).array() + geometry.zero_angle;
}

Encoders::Encoders(const Geometry& geometry, const EncoderOptions& options, std::uint64_t seed)
    : geometry_(geometry), options_(options), before_(Eigen::Vector3d::Zero()) {
  Seeded seeded(seed);
  const double largest = options.largest_offset;
  for (std::int64_t& offset : offset_) { offset = std::llround(seeded.uniform(-largest, largest)); }
}

void Encoders::home() noexcept {
  offset_.fill(0);
  homed_.fill(true);
}

void Encoders::sample(const Eigen::Vector3d& theta1, bool homing) noexcept {
  for (std::size_t leg = 0; leg < 3; ++leg) {
    const auto i = static_cast<Eigen::Index>(leg);
    armed_[leg] = homing && (armed_[leg] || theta1[i] > options_.arming_angle);
    const bool passed =
        sampled_ && before_[i] > geometry_.zero_angle && theta1[i] <= geometry_.zero_angle;
    if (armed_[leg] && passed) {
      offset_[leg] = 0;
      homed_[leg] = true;
      armed_[leg] = false;
    }
    counts_[leg] = wrapped(counts_of_angle(geometry_, theta1[i]) + offset_[leg]);
  }
  before_ = theta1;
  sampled_ = true;
}

}  // namespace palpate::device::falcon
