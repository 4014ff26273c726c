// SPDX-License-Identifier: MIT
#pragma once
/// How fast a network can move, from its springs alone (model/EQUATIONS.md, "Spectral bounds").

#include "model/dynamics/problem.hpp"

namespace palpate {

/// Of the motion about the initial state: M x'' + C x' + K x = 0.
struct SpectralBounds {
  double omega_estimate = 0.0;  ///< highest frequency by iteration, never above the true one [rad/s]
  double omega_upper = 0.0;     ///< guaranteed bound: never below the true one [rad/s]
  double damping_upper = 0.0;   ///< guaranteed bound on the eigenvalues of M^-1 C [1/s]
  /// Smallest c / k of all springs [s]: v'Cv >= this v'Kv at rest lengths. The sideways stiffness
  /// that stretching adds to a spring has no damping of its own.
  double relaxation_lower = 0.0;
};

SpectralBounds spectral_bounds(const NetworkProblem& problem);
SpectralBounds spectral_bounds(const Oscillator& oscillator);

}  // namespace palpate
