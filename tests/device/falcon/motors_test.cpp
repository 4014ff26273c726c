// SPDX-License-Identifier: MIT

#include <limits>

#include "device/falcon/kinematics.hpp"
#include "device/falcon/motors_encoders.hpp"
#include "device/seeded.hpp"
#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate::device::falcon;

const MotorOptions motors{};
const MotorOptions uncalibrated{.words_per_newton_metre = libnifalcon_scale};

TEST("the default scale is Martin and Hillier's: 6616 words per newton metre") {
  CHECK_NEAR(martin_hillier_scale, 6616.0, 0.5);
  CHECK_NEAR(1.0 / martin_hillier_scale, 1.511e-4, 5e-8);
  CHECK_NEAR(largest_torque(motors), 0.619, 5e-4);
  CHECK_NEAR(largest_torque(uncalibrated), 0.410, 5e-4);
}

TEST("words are minus scale times torque, truncated toward zero and clamped") {
  const Command command = words_of_torque(uncalibrated, {1.99e-4, -1.99e-4, 0.5});
  CHECK((command.asked == std::array<std::int64_t, 3>{-1, 1, -5000}));
  CHECK((command.sent == Words{-1, 1, -4096}));
  CHECK(command.saturated);
  CHECK(!words_of_torque(uncalibrated, {0.4096, -0.4096, 0.0}).saturated);
}

TEST("torques that are not finite give words within the range") {
  const double huge = std::numeric_limits<double>::infinity();
  const Command command = words_of_torque(motors, {std::nan(""), huge, -1e300});
  CHECK((command.sent == Words{0, -4096, 4096}));
}

TEST("the electronics clamp what they receive, so a wrapped word pushes the wrong way") {
  const Eigen::Vector3d torque = torque_of_words(motors, {26554, -32768, 100});
  CHECK_NEAR(torque,
             Eigen::Vector3d(-largest_torque(motors), largest_torque(motors),
                             -100.0 / martin_hillier_scale),
             1e-15);
}

TEST("torque and words undo each other to one word") {
  for (int word = -4096; word <= 4096; word += 3) {
    const auto sent = static_cast<std::int16_t>(word);
    const Eigen::Vector3d torque = torque_of_words(motors, {sent, sent, sent});
    CHECK(std::abs(words_of_torque(motors, torque).sent[0] - word) <= 1);
  }
}

TEST("the current follows its words with the time constant, however time is cut") {
  Motors whole(motors), parts(motors);
  const Words words{-1000, 2000, 0};
  whole.command(words);
  parts.command(words);
  whole.advance(1e-3);
  for (int n = 0; n < 10; ++n) { parts.advance(1e-4); }
  const double share = 1.0 - std::exp(-1e-3 / motors.time_constant);
  CHECK_NEAR(whole.torque_after(0.0), share * torque_of_words(motors, words), 1e-15);
  CHECK_NEAR(parts.torque_after(0.0), whole.torque_after(0.0), 1e-15);
  Motors at_once(MotorOptions{.time_constant = 0.0});
  at_once.command(words);
  CHECK_NEAR(at_once.torque_after(0.0), torque_of_words(motors, words), 0.0);
}

TEST("at the centre the forces that the words reach are the published ones") {
  const Eigen::Matrix3d J = *Kinematics().jacobian(Kinematics::centre());
  const auto check_forces = [&](const MotorOptions& options, double weakest,
                                const Eigen::Vector3d& along_axes) {
    const double limit = largest_torque(options);
    // Half a unit of the last digit published.
    CHECK_NEAR(weakest_direction(J, limit).force, weakest, 0.05);
    for (int axis = 0; axis < 3; ++axis) {
      CHECK_NEAR(largest_force(J, Eigen::Vector3d::Unit(axis), limit), along_axes[axis],
                 along_axes[axis] > 20.0 ? 0.1 : 0.05);
    }
  };
  check_forces(motors, 9.2, {10.2, 10.4, 24.5});
  check_forces(uncalibrated, 6.1, {6.8, 6.9, 16.2});
}

constexpr double most = 0.5;  // [N m]

Eigen::Matrix3d jacobian_at(const Eigen::Vector3d& position) {
  return jacobian(*Kinematics{}.legs(position));
}

const std::vector<Eigen::Vector3d> places{
    {0.0, 0.0, 0.12}, {0.02, -0.01, 0.11}, {-0.03, 0.02, 0.14}};

/// Evenly distributed unit vectors (Fibonacci spiral).
std::vector<Eigen::Vector3d> directions(int count) {
  std::vector<Eigen::Vector3d> all;
  for (int n = 0; n < count; ++n) {
    const double z = 1.0 - (2.0 * n + 1.0) / count;
    const double angle = std::numbers::pi * (3.0 - std::sqrt(5.0)) * n;
    const double r = std::sqrt(1.0 - z * z);
    all.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
  }
  return all;
}

TEST("largest forces are where motors reach their limit, and none is below the weakest") {
  for (const Eigen::Vector3d& place : places) {
    const Eigen::Matrix3d j = jacobian_at(place);
    const WeakestDirection weakest = weakest_direction(j, most);
    CHECK_NEAR(weakest.direction.norm(), 1.0, 1e-12);
    CHECK_NEAR(largest_force(j, weakest.direction, most), weakest.force, 1e-12);
    double least = HUGE_VAL;
    for (const Eigen::Vector3d& along : directions(5000)) {
      const double force = largest_force(j, along, most);
      CHECK_NEAR((j.transpose() * (force * along)).cwiseAbs().maxCoeff(), most, 1e-12);
      least = std::min(least, force);
    }
    CHECK(least >= weakest.force * (1.0 - 1e-12));
    CHECK(least < weakest.force * 1.01);  // the sample's directions lie within 0.05 rad of any
  }
}

TEST("the supply holds the force of the data sheet in every direction at the centre") {
  const Eigen::Matrix3d j = *Kinematics().jacobian(Kinematics::centre());
  CHECK_NEAR(weakest_force(motors, j), 8.9, 5e-3);  // 2 lbf
  double least = HUGE_VAL;
  for (const Eigen::Vector3d& along : directions(5000)) {
    const double force = largest_force(motors, j, along);
    const Eigen::Vector3d torque = j.transpose() * (force * along);
    CHECK(torque.cwiseAbs().maxCoeff() <= largest_torque(motors) * (1.0 + 1e-12));
    CHECK_NEAR(supplied(motors, torque), torque, 1e-12);
    least = std::min(least, force);
  }
  CHECK(least >= 8.895);
  CHECK(least < 8.9 * 1.01);
  // Three equal currents along the needle: 3 x 24.96 W at the largest words.
  const double share = std::sqrt(30.0 / (3.0 * motors.largest_power));
  CHECK_NEAR(largest_force(motors, j, Eigen::Vector3d::UnitZ()),
             share * largest_force(j, Eigen::Vector3d::UnitZ(), largest_torque(motors)), 1e-9);
}

TEST("words beyond the supply keep the direction of the torques") {
  Motors device(MotorOptions{.time_constant = 0.0});
  device.command({4096, 4096, 4096});
  CHECK(device.limited());
  const double share = std::sqrt(30.0 / (3.0 * motors.largest_power));
  CHECK_NEAR(device.torque_after(0.0), Eigen::Vector3d::Constant(-share * largest_torque(motors)),
             1e-12);
  device.command({4096, 0, 0});  // 25 W
  CHECK(!device.limited());
}

TEST("a motor that is held at its largest word is folded back to what it can take for ever") {
  const MotorOptions options{.time_constant = 0.0, .thermal_time = 10.0, .continuous_power = 10.0};
  Motors device(options);
  const auto power = [&] {
    const double share = device.torque_after(0.0).x() / largest_torque(options);
    return options.largest_power * share * share;
  };
  double time = 0.0;
  for (; time < 200.0; time += 1e-2) {
    device.command({4096, 0, 0});
    if (time < 3.8) { CHECK(!device.limited()); }  // 8 W after 10 ln(24.96 / 16.96) = 3.86 s
    device.advance(1e-2);
    CHECK(power() <= options.largest_power * (1.0 + 1e-12));
  }
  CHECK_NEAR(power(), options.continuous_power, 1e-3);  // heat and power are equal
  for (time = 0.0; time < 50.0; time += 1e-2) {
    device.command({0, 0, 0});
    device.advance(1e-2);
  }
  device.command({4096, 0, 0});
  CHECK(!device.limited());
}

}  // namespace PALPATE_FILE
