// SPDX-License-Identifier: MIT
#pragma once
/// The hand at the grip: a mass held rigidly by it, drawn by a spring and a damper to where the
/// person wants it. With an arm, the spring ends at the arm's mass, and the arm's spring there.
/// The person bears the weight of hand and arm.

#include <Eigen/Core>
#include <optional>

#include "device/intent.hpp"

namespace palpate::device {

/// Inside the range of S. van Beek et al., Sci. Rep. 5:18004 (2015), for the whole arm and of the
/// grips listed in device/README.md; chosen, not fitted to a person.
struct HandImpedance {
  double mass = 0.15;        ///< [kg]
  double viscosity = 6.0;    ///< [N s/m]
  double stiffness = 400.0;  ///< [N/m]
};
inline constexpr HandImpedance light_hand{.mass = 0.10, .viscosity = 3.0, .stiffness = 150.0};
inline constexpr HandImpedance medium_hand{};
inline constexpr HandImpedance firm_hand{.mass = 0.25, .viscosity = 12.0, .stiffness = 1000.0};
/// The second stage; van Beek et al. fitted 0.554 kg, 6.45 N s/m, 135 N/m to a whole arm.
inline constexpr HandImpedance arm_stage{.mass = 0.55, .viscosity = 6.5, .stiffness = 135.0};
/// Nobody holds the grip.
inline constexpr HandImpedance no_hand{.mass = 0.0, .viscosity = 0.0, .stiffness = 0.0};

struct Hand {
  HandImpedance impedance{};
  std::optional<HandImpedance> arm{};  ///< the two-stage hand
  Intent intent{};
};

/// What the arm does; rests at the intent until the plant has first moved it.
struct ArmMotion {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
};

/// Forces of the hand at one instant.
struct HandForces {
  Eigen::Vector3d on_grip{};  ///< [N]
  Eigen::Vector3d on_arm{};   ///< [N]; zero without an arm
};
HandForces hand_forces(const Hand& hand, const IntentPoint& intent,
                       const Eigen::Vector3d& grip_position, const Eigen::Vector3d& grip_velocity,
                       const ArmMotion& arm) noexcept;

}  // namespace palpate::device
