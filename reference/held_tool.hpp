// SPDX-License-Identifier: MIT
#pragma once
/// A hand that holds a tool through a three-legged haptic device and a sampled coupling, between ticks
/// integrated continuously (model/EQUATIONS.md, "Haptic loop"): CVODE for hand, mechanism and tissue
/// at once. The mechanism's kinematics are written a second time here.

#include <array>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "model/dynamics/spring_network.hpp"
#include "reference/solution.hpp"

namespace palpate::reference {

/// Legs of arm and shin (R. E. Stamper, PhD thesis, University of Maryland 1997): frame x right, y up,
/// z toward the user.
struct LegLengths {
  double arm = 0.0;      ///< a [m]
  double shin = 0.0;     ///< b [m]
  double link = 0.0;     ///< d + e [m]
  double radial = 0.0;   ///< r - c [m]
  double base_lateral = 0.0;      ///< s [m]
  double effector_lateral = 0.0;  ///< f [m]
  std::array<double, 3> azimuth{};  ///< [rad]
};

struct HeldTool {
  LegLengths legs{};
  double grip_mass = 0.0;       ///< effector, hand and what is mounted [kg]
  double arm_inertia = 0.0;     ///< of each leg [kg m^2]
  double hand_stiffness = 0.0;  ///< to the intent [N/m]
  double hand_viscosity = 0.0;  ///< [N s/m]
  double motor_lag = 0.0;       ///< time constant of the torques [s]
  double coupling_stiffness = 0.0;  ///< [N/m]
  double coupling_viscosity = 0.0;  ///< [N s/m]
  double tool_mass = 0.0;       ///< added to node 0, to which the tip sticks [kg]
  double period = 1e-3;         ///< of the loop [s]
  int delay = 0;                ///< 0 or more whole ticks
  Eigen::Vector3d start{0.0, 0.0, 0.125};  ///< of the grip, at rest [m]
  /// Where the hand wants the grip at a time [s]: place [m] and velocity [m/s].
  std::function<void(double time, Eigen::Vector3d& place, Eigen::Vector3d& velocity)> intent{};
};

struct HeldToolMotion {
  std::vector<double> time{};          ///< ticks [s]
  std::vector<Eigen::Vector3d> grip{}; ///< [m]
  std::vector<double> place{};         ///< of the tool, z of node 0 [m]
  std::vector<Eigen::Vector3d> force{};///< asked of the device in the tick that begins there [N]
};

/// `ticks` periods. The tool is stuck to node 0 of `network`, moves along z, which is the device's
/// -z, and begins where that node rests. Throws SolverError.
HeldToolMotion solve_held_tool(const HeldTool& held, const SpringNetwork& network, long ticks,
                               const Tolerance& tolerance);

}  // namespace palpate::reference
