// SPDX-License-Identifier: MIT
#pragma once
/// Closed forms of the spring-mass-damper (model/EQUATIONS.md, Eqs. 3-6).

#include <Eigen/Core>
#include <string_view>
#include <vector>

#include "model/problem/scene.hpp"

namespace palpate::reference {

struct OscillatorState {
  double position = 0.0;  ///< [m]
  double velocity = 0.0;  ///< [m/s]
};

/// Returns the damping ratio S = c / (2 sqrt(m k)) [1].
double damping_ratio(const Oscillator& oscillator);

/// Returns "driven", "undamped", "underdamped", "critically damped", "overdamped" or "negatively
/// damped".
const char* damping_class(const Oscillator& oscillator);

/// Returns the exact motion at time t [s] in every regime (S < 0, = 0, < 1, = 1, > 1), driven or
/// not; smooth through S = 1 to 1e-13 relative. k = 0 (a free mass with drag) is allowed.
OscillatorState exact_motion(const Oscillator& oscillator, double t);

/// Eq. 6 in its three readings; A is the amplitude of the paper's figures, exact_motion the third.
/// printed: A exp(-gamma t) cos(omega0 t p) with p = 0. plotted: A exp(-gamma t) cos(omega0 t + p).
double equation_6_printed(const Oscillator& oscillator, double amplitude, double t);
double equation_6_plotted(const Oscillator& oscillator, double amplitude, double phase, double t);

// Exact step matrices of the stepping schemes for the linear oscillator m x'' + c x' + k x = 0:
// one 2x2 matrix per step. They are derived in long double from the definitions of the schemes,
// independently of the model's code, so that it can be tested to rounding and not only to O(h^p).
//
// The state is (x, v). The instant of v depends on the scheme:
//   at the instant of x: "euler", "euler-cromer", "feynman-newton-printed", "velocity-verlet",
//       "rk4", "implicit-euler", "implicit-midpoint";
//   half a step later than x: "feynman-newton", "leapfrog", both started with
//       v(h/2) = v(0) + (h/2) a(x(0), v(0)).

using Amplification = Eigen::Matrix<long double, 2, 2>;
using DiscreteState = Eigen::Matrix<long double, 2, 1>;

const std::vector<std::string_view>& discrete_schemes();
bool velocity_is_staggered(std::string_view scheme);

/// Returns the matrix of one undriven step of h [s]. Throws std::invalid_argument for an unknown
/// scheme.
Amplification amplification(std::string_view scheme, const Oscillator& oscillator, double h);

/// Returns (x(0), v(0)), or (x(0), v(h/2)) for a staggered scheme.
DiscreteState discrete_start(std::string_view scheme, const Oscillator& oscillator, double h);

/// Returns the state after `steps` steps, A^steps times the start, by repeated squaring.
DiscreteState discrete_state(std::string_view scheme, const Oscillator& oscillator, double h,
                             long steps);

long double spectral_radius(const Amplification& matrix);

/// Returns the largest h [s] such that no smaller step amplifies: infinity for schemes that never
/// amplify, 0 if arbitrarily small steps amplify. omega0 = sqrt(k/m) [rad/s], damping_ratio = c /
/// (2 sqrt(k m)).
double stability_limit(std::string_view scheme, double omega0, double damping_ratio);

}  // namespace palpate::reference
