// SPDX-License-Identifier: MIT
#include "device/falcon/friction.hpp"

#include <Eigen/LU>
#include <cmath>

namespace palpate::device::falcon {
namespace {

constexpr double rounding = 1e-12;  // share of the limit, of the largest acceleration

/// Whether no law of friction is broken in the arms that were at rest.
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
  constexpr std::array<int, 3> choices{0, 1, -1};  // stuck if it can be
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

}  // namespace palpate::device::falcon
