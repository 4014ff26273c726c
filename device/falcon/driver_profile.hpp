// SPDX-License-Identifier: MIT
#pragma once
/// What a driver makes of counts and forces. `CorrectProfile` solves the mechanism; `StockProfile`
/// errs the way libnifalcon (f7c727a) does, so that results can be given for both.

#include "device/falcon/encoders.hpp"
#include "device/falcon/kinematics.hpp"
#include "device/falcon/motors.hpp"

namespace palpate::device::falcon {

class DriverProfile {
 public:
  virtual ~DriverProfile() = default;
  /// Position [m] that the driver reports for these counts; the last one when it finds none.
  virtual Eigen::Vector3d position(const Counts& counts) noexcept = 0;
  /// Words that it sends for a force on the hand [N], with the grip where it believes it to be.
  virtual Command words(const Eigen::Vector3d& position,
                        const Eigen::Vector3d& force_on_hand) noexcept = 0;
};

/// Exact forward solution, true Jacobian, words clamped.
class CorrectProfile final : public DriverProfile {
 public:
  explicit CorrectProfile(const Kinematics& kinematics = Kinematics(),
                          const MotorOptions& motors = {})
      : kinematics_(kinematics), motors_(motors) {}
  Eigen::Vector3d position(const Counts& counts) noexcept override;
  Command words(const Eigen::Vector3d& position,
                const Eigen::Vector3d& force_on_hand) noexcept override;

 private:
  Kinematics kinematics_;
  MotorOptions motors_;
  Eigen::Vector3d position_ = Kinematics::cold_start();
};

/// libnifalcon's three defects. (1) In the row of each leg the rate along z has sin(theta2) squared
/// where sin(theta2) sin(theta3) belongs (its issue 66), in forces and read-out alike. (2) Words
/// are neither clamped nor calibrated: 10,000 per N m, low 16 bits sent. (3) The read-out takes
/// half steps of Newton's method and stops with the first that began within 0.01 rad: at loop rate
/// a one-pole filter.
class StockProfile final : public DriverProfile {
 public:
  explicit StockProfile(const Geometry& geometry = libnifalcon()) : kinematics_(geometry) {}
  Eigen::Vector3d position(const Counts& counts) noexcept override;
  Command words(const Eigen::Vector3d& position,
                const Eigen::Vector3d& force_on_hand) noexcept override;

 private:
  Kinematics kinematics_;
  Eigen::Vector3d position_{0.0, 0.0, 0.080};  ///< where its first read-out starts
};

/// The Jacobian that libnifalcon uses [m/rad], wrong in z; nothing beyond reach.
std::optional<Eigen::Matrix3d> stock_jacobian(const Kinematics& kinematics,
                                              const Eigen::Vector3d& position) noexcept;

}  // namespace palpate::device::falcon
