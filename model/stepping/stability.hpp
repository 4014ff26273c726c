// SPDX-License-Identifier: MIT
#pragma once
/// Bounds on the frequencies and damping rates of a network, from its springs (model/EQUATIONS.md,
/// "Spectral bounds").

#include <optional>

#include "model/problem/problem.hpp"
#include "model/stepping/integrator_info.hpp"

namespace palpate {

/// Spectral bounds of the motion about the initial state, M x'' + C x' + K x = 0.
struct SpectralBounds {
  double omega_estimate = 0.0;  ///< highest frequency by iteration, never above it [rad/s]
  double omega_upper = 0.0;     ///< guaranteed upper bound of the highest frequency [rad/s]
  double damping_upper = 0.0;   ///< guaranteed upper bound of the eigenvalues of M^-1 C [1/s]
  /// Smallest c / k of all springs [s]: v'Cv >= this v'Kv at rest lengths. The transverse stiffness
  /// of a stretched spring has no damping of its own.
  double relaxation_lower = 0.0;
};

SpectralBounds spectral_bounds(const NetworkProblem& problem);
SpectralBounds spectral_bounds(const Oscillator& oscillator);

/// Lowest mode of elastic motion about the initial state.
struct FirstMode {
  double omega = 0.0;          ///< [rad/s]
  double damping_ratio = 0.0;  ///< of the dampers of springs and cells [1]
};
/// Returns the first mode by inverse iteration. Empty for tissue that nothing holds, and above 8000
/// free nodes, where the factors of K take longer than a scene should take to load.
std::optional<FirstMode> first_mode(const NetworkProblem& problem);

/// Returns the damping ratio [1] with which steps of h move a mode: that of its decay per radian. 1
/// if it does not oscillate. Implicit Euler adds about omega h / 2.
double stepped_damping_ratio(const IntegratorInfo& scheme, const FirstMode& mode, double h);

/// Returns the spectral radius of one step of h on x'' + damping x' + omega^2 x = 0.
double amplification(const IntegratorInfo& scheme, double omega, double damping, double h);

/// Returns the largest h [s] up to which no step amplifies this oscillator; infinite if none does,
/// 0 if a step of 1e-4 / max(omega, damping) already does. omega [rad/s], damping = c/m [1/s].
double stable_step(const IntegratorInfo& scheme, double omega, double damping);

/// Returns the largest step that is stable for every oscillator within these bounds. Each
/// eigenvalue of the network is a root of l^2 + g l + w^2 with w <= omega_upper, g <= damping_upper
/// and g >= relaxation_lower w^2 (Rayleigh quotients), also without proportional damping.
double stable_step(const IntegratorInfo& scheme, const SpectralBounds& bounds);

}  // namespace palpate
