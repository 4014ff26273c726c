// SPDX-License-Identifier: MIT
#pragma once
/// When a sampled virtual wall is stable, and when passive: mass m and viscosity b behind a
/// zero-order hold of period T, a wall K with a backward difference B, computed `delay` ticks late.

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
  int delay = 0;           ///< whole ticks from a position to the force that it leads to
  double period = 1e-3;    ///< T [s]
};

/// Largest root of the closed loop's characteristic polynomial
///   z^(d+1) (z - 1)(z - a) + (n1 z + n0)(h1 z + h0),   a = exp(-b T / m), tau = m / b,
///   n1 = (T - tau (1 - a)) / b, n0 = (tau (1 - a) - T a) / b, h1 = K + B / T, h0 = -B / T,
/// the exact z transform of the held plant with the wall; stable where it is below 1.
double largest_root(const WallLoop& loop, double stiffness);

/// The stiffness K [N/m] above which the loop is unstable, to 1e-12 of itself. 0 where no stiffness
/// is stable.
double critical_stiffness(const WallLoop& loop);

/// Colgate & Schenkel (1997): passive for K < 2 (b - |B|) / T, no delay; below 0: none is.
double passive_stiffness(const WallLoop& loop);

/// Gil, Avello, Rubio & Florez (2004), Hulin et al. (2014), small damping: K < (b + B) / (T / 2 + d
/// T).
double linear_rule(const WallLoop& loop);

/// Abbott & Okamura (2005), encoder step D [m] and Coulomb friction f [N]: K <= min(2 b / T, 2 f /
/// D).
double quantised_stiffness(const WallLoop& loop, double encoder_step, double coulomb_friction);

// Value and first two derivatives over one parameter, carried through formulas exactly.

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
/// g(a) from g, g' and g'' at a's value.
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
/// Angle of the point (x, y) from the x axis, x > 0 or y > 0.
inline Taylor angle(Taylor y, Taylor x) {
  // d atan2 = (x dy - y dx) / r^2, and once more.
  const double r2 = x.value * x.value + y.value * y.value;
  const double turn = x.value * y.first - y.value * x.first;
  const double first = turn / r2;
  const double r2_first = 2.0 * (x.value * x.first + y.value * y.first);
  const double turn_first = x.value * y.second - y.value * x.second;
  return {std::atan2(y.value, x.value), first, (turn_first - first * r2_first) / r2};
}

// A hand that holds a tool through a three-legged haptic device and a sampled coupling, between
// ticks integrated continuously (model/EQUATIONS.md, "Haptic loop"): CVODE for hand, mechanism and
// tissue at once. The mechanism's kinematics are written a second time here.

/// Legs of arm and shin (R. E. Stamper, PhD thesis, University of Maryland 1997): frame x right, y
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
  double grip_mass = 0.0;                  ///< effector, hand and what is mounted [kg]
  double arm_inertia = 0.0;                ///< of each leg [kg m^2]
  double hand_stiffness = 0.0;             ///< to the intent [N/m]
  double hand_viscosity = 0.0;             ///< [N s/m]
  double motor_lag = 0.0;                  ///< time constant of the torques [s]
  double coupling_stiffness = 0.0;         ///< [N/m]
  double coupling_viscosity = 0.0;         ///< [N s/m]
  double tool_mass = 0.0;                  ///< added to node 0, to which the tip sticks [kg]
  double period = 1e-3;                    ///< of the loop [s]
  int delay = 0;                           ///< 0 or more whole ticks
  Eigen::Vector3d start{0.0, 0.0, 0.125};  ///< of the grip, at rest [m]
  /// Where the hand wants the grip at a time [s]: place [m] and velocity [m/s].
  std::function<void(double time, Eigen::Vector3d& place, Eigen::Vector3d& velocity)> intent{};
};

struct HeldToolMotion {
  std::vector<double> time{};            ///< ticks [s]
  std::vector<Eigen::Vector3d> grip{};   ///< [m]
  std::vector<double> place{};           ///< of the tool, z of node 0 [m]
  std::vector<Eigen::Vector3d> force{};  ///< asked of the device in the tick that begins there [N]
};

/// `ticks` periods. The tool is stuck to node 0 of `network`, moves along z, which is the device's
/// -z, and begins where that node rests. Throws SolverError.
HeldToolMotion solve_held_tool(const HeldTool& held, const SpringNetwork& network, long ticks,
                               const Tolerance& tolerance);

}  // namespace palpate::reference
