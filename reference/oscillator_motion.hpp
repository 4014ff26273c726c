// SPDX-License-Identifier: MIT
#pragma once
/// Closed forms of the spring-mass-damper (model/EQUATIONS.md, Eqs. 3-6).

#include "model/problem/scene.hpp"

namespace palpate {

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

}  // namespace palpate
