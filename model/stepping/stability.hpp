// SPDX-License-Identifier: MIT
#pragma once
/// How fast a network can move, from its springs alone (model/EQUATIONS.md, "Spectral bounds").

#include "model/problem/problem.hpp"
#include "model/stepping/integrator_info.hpp"

namespace palpate {

/// Of the motion about the initial state: M x'' + C x' + K x = 0.
struct SpectralBounds {
  double omega_estimate =
      0.0;                     ///< highest frequency by iteration, never above the true one [rad/s]
  double omega_upper = 0.0;    ///< guaranteed bound: never below the true one [rad/s]
  double damping_upper = 0.0;  ///< guaranteed bound on the eigenvalues of M^-1 C [1/s]
  /// Smallest c / k of all springs [s]: v'Cv >= this v'Kv at rest lengths. The sideways stiffness
  /// that stretching adds to a spring has no damping of its own.
  double relaxation_lower = 0.0;
};

SpectralBounds spectral_bounds(const NetworkProblem& problem);
SpectralBounds spectral_bounds(const Oscillator& oscillator);

// Largest stable step of any registered scheme, from the scheme's own step on the scalar
// oscillator: no formula per scheme, so a new scheme has its limit at once.

/// Spectral radius of one step of h on x'' + damping x' + omega^2 x = 0.
double amplification(const IntegratorInfo& scheme, double omega, double damping, double h);

/// Largest h [s] up to which no step amplifies that oscillator (infinite when none does, 0 when one
/// of 1e-4 / max(omega, damping) already does). omega [rad/s], damping = c/m [1/s].
double stable_step(const IntegratorInfo& scheme, double omega, double damping);

/// The same for every oscillator that a network with these bounds can contain. Each eigenvalue of
/// its motion is a root of l^2 + g l + w^2 with w <= omega_upper, g <= damping_upper and
/// g >= relaxation_lower w^2 (Rayleigh quotients), whether or not the damping is proportional.
double stable_step(const IntegratorInfo& scheme, const SpectralBounds& bounds);

}  // namespace palpate
