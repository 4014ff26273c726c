// SPDX-License-Identifier: MIT

#include "device/falcon/driver.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace palpate::device::falcon {
namespace {

// Baud rates of the phases of libnifalcon's serial driver; links without a rate ignore them.
constexpr unsigned boot_baud = 9600;
constexpr unsigned load_baud = 140000;
constexpr unsigned run_baud = 1456312;
constexpr std::size_t block_bytes = 62;  // payload of one USB transfer of the real device

constexpr double most_torque = 30.0;  // limit at which libnifalcon scales down [N m]; never reached
constexpr double close_enough = 0.01;  // [rad]
constexpr int most_tries = 15;

}  // namespace

OpenResult Driver::open(std::span<const std::uint8_t> image) noexcept {
  link_.set_baud(boot_baud);
  link_.set_dtr(false);
  link_.set_dtr(true);
  if (!hail()) {
    link_.set_baud(run_baud);
    return probe() ? OpenResult::was_running : OpenResult::no_answer;
  }
  link_.set_dtr(false);
  link_.set_baud(load_baud);
  if (!upload(image)) { return OpenResult::echo_differs; }
  link_.set_baud(run_baud);
  return probe() ? OpenResult::loaded : OpenResult::no_answer;
}

bool Driver::hail() noexcept {
  for (int n = 0; n < options_.hails; ++n) {
    discard();
    (void)link_.write(hail_request);
    if (await(hail_reply, options_.hail_patience)) { return true; }
  }
  return false;
}

bool Driver::upload(std::span<const std::uint8_t> image) noexcept {
  discard();
  (void)link_.write({&load_request, 1});
  bool right = await({&load_request, 1}, options_.hail_patience);
  while (right && !image.empty()) {
    const auto block = image.first(std::min(block_bytes, image.size()));
    (void)link_.write(block);
    right = await(block, options_.hail_patience);
    image = image.subspan(block.size());
  }
  return right;
}

/// Waits for exactly these bytes after at most a few stray ones: some hosts read a zero byte first
/// (libnifalcon).
bool Driver::await(std::span<const std::uint8_t> expected, double patience_s) noexcept {
  const double deadline = link_.now() + patience_s;
  std::size_t matched = 0;
  while (matched < expected.size()) {
    std::uint8_t byte = 0;
    if (link_.read({&byte, 1}) == 0) {
      if (link_.now() >= deadline || link_.ended()) { return false; }
      (void)link_.wait_until(deadline);
      continue;
    }
    if (byte == expected[matched]) {
      ++matched;
    } else if (matched > 0 || byte != 0) {
      return false;
    }
  }
  return true;
}

bool Driver::probe() noexcept {
  for (int n = 0; n < options_.probes; ++n) {
    if (exchange({})) { return true; }
  }
  return false;
}

std::optional<DevicePacket> Driver::exchange(const HostPacket& request) noexcept {
  const std::optional<DevicePacket> late = read_newest(counts_.late);
  ++counts_.requests;
  const double deadline = link_.now() + options_.reply_deadline;
  (void)link_.write(encode(request));
  std::int64_t replies = 0;
  std::optional<DevicePacket> newest = read_newest(replies);
  for (bool waits = true; waits && !newest && !link_.ended(); newest = read_newest(replies)) {
    waits = link_.now() < deadline;
    (void)link_.wait_until(deadline);
  }
  ++(newest ? counts_.replies : counts_.lost);
  if (replies > 1) { counts_.superfluous += replies - 1; }
  return newest || !options_.keep_late ? newest : late;
}

std::optional<DevicePacket> Driver::read_newest(std::int64_t& count) noexcept {
  std::array<std::uint8_t, 512> buffer;
  std::optional<DevicePacket> newest;
  for (std::size_t bytes = 0; (bytes = link_.read(buffer)) > 0;) {
    for (std::size_t n = 0; n < bytes; ++n) {
      const std::optional<DevicePacket> packet = reader_.take(buffer[n]);
      if (!packet) { continue; }
      newest = packet;
      ++count;
    }
  }
  return newest;
}

void Driver::discard() noexcept {
  std::array<std::uint8_t, 512> buffer;
  while (link_.read(buffer) > 0) {}
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

DriverProfile::DriverProfile(Kind kind, const Kinematics& kinematics, const MotorOptions& motors)
    : kind_(kind),
      kinematics_(kinematics),
      motors_(kind == Kind::stock ? MotorOptions{.words_per_newton_metre = libnifalcon_scale}
                                  : motors),
      position_(kind == Kind::stock ? Eigen::Vector3d(0.0, 0.0, 0.080) : Kinematics::cold_start()) {
}

Eigen::Vector3d DriverProfile::position(const Counts& counts) noexcept {
  const Eigen::Vector3d theta1 = angles_of_counts(kinematics_.geometry(), counts);
  if (kind_ == Kind::stock) {
    stock_steps(theta1);
  } else {
    position_ = kinematics_.forward(theta1, position_).value_or(position_);
  }
  return position_;
}

void DriverProfile::stock_steps(const Eigen::Vector3d& theta1) noexcept {
  Eigen::Vector3d guess = position_;
  double share = 0.5;
  double error_before = HUGE_VAL;
  for (int n = 0; n < most_tries; ++n) {
    const auto angles = kinematics_.inverse(guess);
    const auto jacobian = stock_jacobian(kinematics_, guess);
    if (!angles || !jacobian) { break; }
    const Eigen::Vector3d miss = theta1 - angles->theta1;
    guess += share * (*jacobian * miss);
    const double error = miss.norm();
    if (error < close_enough) {  // of the guess before the step
      position_ = guess;
      break;
    }
    if (error > error_before) { share *= 0.5; }
    error_before = error;
  }
}

Command DriverProfile::words(const Eigen::Vector3d& position,
                             const Eigen::Vector3d& force_on_hand) const noexcept {
  const auto jacobian =
      kind_ == Kind::stock ? stock_jacobian(kinematics_, position) : kinematics_.jacobian(position);
  if (!jacobian) { return {}; }
  Eigen::Vector3d torque = torque_of_force(*jacobian, force_on_hand);
  if (kind_ == Kind::correct) { return words_of_torque(motors_, torque); }
  const double largest = torque.cwiseAbs().maxCoeff();
  if (largest > most_torque) { torque *= most_torque / largest; }
  Command command = words_of_torque(motors_, torque);
  for (std::size_t leg = 0; leg < 3; ++leg) { command.sent[leg] = wrapped(command.asked[leg]); }
  return command;
}

}  // namespace palpate::device::falcon
