// SPDX-License-Identifier: MIT
#pragma once
/// Stability and passivity of a sampled virtual wall: mass m and viscosity b behind a zero-order
/// hold of period T, a wall K with a backward difference B, computed `delay` ticks late.

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "model/problem/spring_network.hpp"
#include "reference/solution.hpp"

namespace palpate::reference {

struct WallLoop {
  double mass = 0.1;       ///< m of device and hand [kg]
  double viscosity = 0.5;  ///< b of device and hand [N s/m]
  double damping = 0.0;    ///< B of the wall [N s/m]
  int delay = 0;           ///< whole ticks from a position to the resulting force
  double period = 1e-3;    ///< T [s]
};

/// Largest root of the closed loop's characteristic polynomial
///   z^(d+1) (z - 1)(z - a) + (n1 z + n0)(h1 z + h0),   a = exp(-b T / m), tau = m / b,
///   n1 = (T - tau (1 - a)) / b, n0 = (tau (1 - a) - T a) / b, h1 = K + B / T, h0 = -B / T,
/// the exact z transform of the held plant with the wall; stable where it is below 1.
double largest_root(const WallLoop& loop, double stiffness);

/// Returns the stiffness K [N/m] above which the loop is unstable, with a relative error of 1e-12,
/// or 0 if no stiffness is stable.
double critical_stiffness(const WallLoop& loop);

/// Returns the limit of passive stiffness [N/m] by Colgate & Schenkel (1997), K < 2 (b - |B|) / T,
/// without delay; a negative value means that no stiffness is passive.
double passive_stiffness(const WallLoop& loop);

/// Returns the stability limit [N/m] for small damping by Gil, Avello, Rubio & Florez (2004) and
/// Hulin et al. (2014): K < (b + B) / (T / 2 + d T).
double linear_rule(const WallLoop& loop);

/// Returns the limit [N/m] by Abbott & Okamura (2005) for an encoder step D [m] and Coulomb
/// friction f [N]: K <= min(2 b / T, 2 f / D).
double quantised_stiffness(const WallLoop& loop, double encoder_step, double coulomb_friction);

// Value and first two derivatives with respect to one parameter (exact automatic differentiation).

struct Taylor {
  double value = 0.0;
  double first = 0.0;
  double second = 0.0;
};

inline Taylor operator+(Taylor a, Taylor b) {
  return {a.value + b.value, a.first + b.first, a.second + b.second};
}
inline Taylor operator-(Taylor a, Taylor b) {
  return {a.value - b.value, a.first - b.first, a.second - b.second};
}
inline Taylor operator+(Taylor a, double b) { return {a.value + b, a.first, a.second}; }
inline Taylor operator*(double a, Taylor b) { return {a * b.value, a * b.first, a * b.second}; }
inline Taylor operator*(Taylor a, Taylor b) {
  return {a.value * b.value, a.first * b.value + a.value * b.first,
          a.second * b.value + 2.0 * a.first * b.first + a.value * b.second};
}
/// Returns g(a) from g, g' and g'' at the value of a.
inline Taylor chain(Taylor a, double g, double slope, double curvature) {
  return {g, slope * a.first, slope * a.second + curvature * a.first * a.first};
}
inline Taylor inverse(Taylor a) {
  const double g = 1.0 / a.value;
  return chain(a, g, -g * g, 2.0 * g * g * g);
}
inline Taylor sqrt(Taylor a) {
  const double g = std::sqrt(a.value);
  return chain(a, g, 0.5 / g, -0.25 / (g * a.value));
}
inline Taylor acos(Taylor a) {
  const double w = 1.0 - a.value * a.value;
  return chain(a, std::acos(a.value), -1.0 / std::sqrt(w), -a.value / (w * std::sqrt(w)));
}
/// Returns the angle of the point (x, y) from the x axis, for x > 0 or y > 0 [rad].
inline Taylor angle(Taylor y, Taylor x) {
  // d atan2 = (x dy - y dx) / r^2, and its derivative.
  const double r2 = x.value * x.value + y.value * y.value;
  const double turn = x.value * y.first - y.value * x.first;
  const double first = turn / r2;
  const double r2_first = 2.0 * (x.value * x.first + y.value * y.first);
  const double turn_first = x.value * y.second - y.value * x.second;
  return {std::atan2(y.value, x.value), first, (turn_first - first * r2_first) / r2};
}

// Tool held by a hand through a three-legged haptic device and a sampled coupling
// (model/EQUATIONS.md, "Haptic loop"). Between ticks CVODE integrates hand, mechanism and tissue
// together. The kinematics of the mechanism are implemented independently here.

/// Lengths of the legs (R. E. Stamper, PhD thesis, University of Maryland 1997). Frame: x right, y
/// up, z toward the user.
struct LegLengths {
  double arm = 0.0;                 ///< a [m]
  double shin = 0.0;                ///< b [m]
  double link = 0.0;                ///< d + e [m]
  double radial = 0.0;              ///< r - c [m]
  double base_lateral = 0.0;        ///< s [m]
  double effector_lateral = 0.0;    ///< f [m]
  std::array<double, 3> azimuth{};  ///< [rad]
};

struct HeldTool {
  LegLengths legs{};
  double grip_mass = 0.0;                  ///< effector, hand and mounted tool [kg]
  double arm_inertia = 0.0;                ///< of each leg [kg m^2]
  double hand_stiffness = 0.0;             ///< to the intended position [N/m]
  double hand_viscosity = 0.0;             ///< [N s/m]
  double motor_lag = 0.0;                  ///< time constant of the torques [s]
  double coupling_stiffness = 0.0;         ///< [N/m]
  double coupling_viscosity = 0.0;         ///< [N s/m]
  double tool_mass = 0.0;                  ///< added to node 0, to which the tip is attached [kg]
  double period = 1e-3;                    ///< period of the loop [s]
  int delay = 0;                           ///< 0 or more whole ticks
  Eigen::Vector3d start{0.0, 0.0, 0.125};  ///< position of the grip at rest [m]
  /// Intended motion of the grip at a time [s]: position [m] and velocity [m/s].
  std::function<void(double time, Eigen::Vector3d& place, Eigen::Vector3d& velocity)> intent{};
};

/// Integrates `ticks` periods. The columns are device.{x,y,z}_m (grip), tool.insertion_m (z of node
/// 0) and device.command_{x,y,z}_n (force sent to the device in the tick). The tool is attached to
/// node 0 of `network`, moves along z, which is the device's -z, and starts at the rest position of
/// that node. Throws SolverError.
Trace solve_held_tool(const HeldTool& held, const SpringNetwork& network, long ticks,
                      const Tolerance& tolerance);

}  // namespace palpate::reference
