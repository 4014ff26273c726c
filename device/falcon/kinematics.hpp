// SPDX-License-Identifier: MIT
#pragma once
/// Kinematics of the Falcon (device/README.md, "Legs"): positions [m] in libnifalcon's frame, arm
/// angles [rad] and torques at the arms [N m] growing outward. Nothing here allocates.
/// After R. E. Stamper, PhD thesis, University of Maryland 1997, chapters 2-4, with the lateral
/// offset that A. Barrow added in libnifalcon.

#include <Eigen/Core>
#include <array>
#include <optional>

#include "device/falcon/leg.hpp"

namespace palpate::device::falcon {

/// Of legs 1, 2, 3 [rad].
struct LegAngles {
  Eigen::Vector3d theta1{};  ///< arm, from the base plane
  Eigen::Vector3d theta2{};  ///< shin's projection, from the base plane
  Eigen::Vector3d theta3{};  ///< shin, from the leg's side
};

class Kinematics {
 public:
  explicit Kinematics(const Geometry& geometry = libnifalcon());
  [[nodiscard]] const Geometry& geometry() const noexcept { return geometry_; }

  /// Centre of the workspace, and where a cold forward solution starts.
  static Eigen::Vector3d centre() { return {0.0, 0.0, 0.125}; }
  static Eigen::Vector3d cold_start() { return {0.0, 0.0, 0.120}; }

  /// The three legs at a position; nothing when it is beyond reach, or when the mechanism would
  /// have to collapse on its way there from the centre (another assembly). Joint stops are not
  /// asked.
  [[nodiscard]] std::optional<std::array<Leg, 3>> legs(
      const Eigen::Vector3d& position) const noexcept;
  /// Closed form; error below 1e-12 rad except within 1e-9 m of the edge of reach.
  [[nodiscard]] std::optional<LegAngles> inverse(const Eigen::Vector3d& position) const noexcept;
  /// Newton's method on the three squared closures, no step longer than 30 mm; where that leads
  /// to another assembly or nowhere, it starts again from three rings round the workspace.
  /// Error below 1e-12 m. Nothing when the mechanism cannot stand at these angles.
  [[nodiscard]] std::optional<Eigen::Vector3d> forward(
      const Eigen::Vector3d& theta1, const Eigen::Vector3d& start = cold_start()) const noexcept;

  /// J = d(position)/d(theta1) [m/rad]; the columns are the legs.
  [[nodiscard]] std::optional<Eigen::Matrix3d> jacobian(
      const Eigen::Vector3d& position) const noexcept;

  [[nodiscard]] const LegFrame& frame(int leg) const noexcept {
    return frames_[static_cast<std::size_t>(leg)];
  }

 private:
  /// Derivative [m^2/m] of the halved closures at a guess, and their values [m^2].
  void closures(const Eigen::Vector3d& cosine, const Eigen::Vector3d& sine,
                const Eigen::Vector3d& position, Eigen::Matrix3d& slope,
                Eigen::Vector3d& value) const noexcept;
  [[nodiscard]] std::optional<Eigen::Vector3d> newton(const Eigen::Vector3d& theta1,
                                                      const Eigen::Vector3d& start) const noexcept;

  Geometry geometry_;
  std::array<LegFrame, 3> frames_{};
};

/// theta1 of the three arms [rad].
Eigen::Vector3d angles_at_base(const std::array<Leg, 3>& legs) noexcept;

/// d(theta1)/d(position) [rad/m], the inverse of J; singular only at the edge of reach.
Eigen::Matrix3d inverse_jacobian(const std::array<Leg, 3>& legs) noexcept;
/// J from the same legs, well defined up to the edge of reach.
Eigen::Matrix3d jacobian(const std::array<Leg, 3>& legs) noexcept;

/// Torques at the arms that let the device push with `force_on_hand`: J^T F [N m].
inline Eigen::Vector3d torque_of_force(const Eigen::Matrix3d& jacobian,
                                       const Eigen::Vector3d& force_on_hand) noexcept {
  return jacobian.transpose() * force_on_hand;
}
/// The opposite way: force on the hand [N] of torques at the arms.
Eigen::Vector3d force_of_torque(const Eigen::Matrix3d& jacobian,
                                const Eigen::Vector3d& torque) noexcept;

}  // namespace palpate::device::falcon
