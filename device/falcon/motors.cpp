// SPDX-License-Identifier: MIT
#include "device/falcon/motors.hpp"

#include <algorithm>
#include <cmath>

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

Eigen::Vector3d Motors::torque_after(double duration) const noexcept {
  if (options_.time_constant <= 0.0) { return target_; }
  return target_ + (torque_ - target_) * std::exp(-duration / options_.time_constant);
}

}  // namespace palpate::device::falcon
