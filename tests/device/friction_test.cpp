// SPDX-License-Identifier: MIT
#include "device/falcon/friction.hpp"

#include "device/seeded.hpp"
#include "tests/check.hpp"

namespace {

using namespace palpate::device::falcon;
constexpr double limit = 4e-3;

/// Random arms; the mobility is that of some positive mass.
ArmDynamics random_arms(palpate::device::Seeded& seeded, double push) {
  Eigen::Matrix3d any;
  ArmDynamics arms;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) { any(i, j) = seeded.uniform(-1.0, 1.0); }
    arms.free[i] = seeded.uniform(-push, push);
  }
  arms.mobility = 1000.0 * (any * any.transpose() + 0.1 * Eigen::Matrix3d::Identity());
  return arms;
}

TEST("sliding arms feel the limit against their motion") {
  palpate::device::Seeded seeded(1);
  const ArmDynamics arms = random_arms(seeded, 10.0);
  CHECK_NEAR(friction_torque(arms, {1, -1, 1}, limit), Eigen::Vector3d(-limit, limit, -limit), 0.0);
}

TEST("what holds the stuck arms leaves them without acceleration") {
  palpate::device::Seeded seeded(2);
  for (int n = 0; n < 100; ++n) {
    const ArmDynamics arms = random_arms(seeded, 10.0);
    for (const Slip& slip : {Slip{0, 0, 0}, Slip{0, 1, 0}, Slip{-1, 0, 1}}) {
      const Eigen::Vector3d acceleration =
          arms.free + arms.mobility * friction_torque(arms, slip, limit);
      for (int i = 0; i < 3; ++i) {
        if (slip[static_cast<std::size_t>(i)] == 0) { CHECK_NEAR(acceleration[i], 0.0, 1e-10); }
      }
    }
  }
}

TEST("arms at rest always find one lawful answer, stuck, sliding or mixed") {
  palpate::device::Seeded seeded(3);
  std::array<int, 4> stuck_count{};
  for (int n = 0; n < 4000; ++n) {
    const ArmDynamics arms = random_arms(seeded, n % 2 == 0 ? 6.0 : 30.0);
    const Slip slip = settled(arms, {0, 0, 0}, limit);
    const Eigen::Vector3d torque = friction_torque(arms, slip, limit);
    const Eigen::Vector3d acceleration = arms.free + arms.mobility * torque;
    int stuck = 0;
    for (std::size_t leg = 0; leg < 3; ++leg) {
      const auto i = static_cast<Eigen::Index>(leg);
      CHECK(std::abs(torque[i]) <= limit * (1.0 + 1e-9));
      CHECK(slip[leg] == 0 ? std::abs(acceleration[i]) < 1e-9
                           : slip[leg] * acceleration[i] > -1e-9);
      stuck += slip[leg] == 0 ? 1 : 0;
    }
    ++stuck_count[static_cast<std::size_t>(stuck)];
  }
  for (const int count : stuck_count) { CHECK(count > 50); }  // the sample meets every case
}

TEST("arms that move are not touched") {
  palpate::device::Seeded seeded(4);
  for (int n = 0; n < 100; ++n) {
    const Slip slip = settled(random_arms(seeded, 30.0), {1, 0, -1}, limit);
    CHECK(slip[0] == 1 && slip[2] == -1);
  }
}

}  // namespace
