// SPDX-License-Identifier: MIT
#pragma once
/// Test fixture of group "stability": small networks, exact spectra, theoretical limits.

#include <Eigen/Core>

#include "model/problem/spring_network.hpp"
#include "model/stepping/integrator.hpp"
#include "validation/claims/network_fixture.hpp"

namespace palpate::stability {

/// Returns n^3 nodes of 1 g, 5 mm apart, 26 neighbours of 50 N/m, the far face fixed. Damping is
/// proportional: every viscosity is `relaxation` [s] times the stiffness.
SpringNetwork cube(int n, double relaxation);

using networks::automatic_scene;
using networks::displace;

/// Exact angular frequencies about the initial state [rad/s], ascending, and rates of M^-1 C [1/s].
struct Spectrum {
  Eigen::VectorXd omega{};
  double damping_maximum = 0.0;
};
Spectrum spectrum_of(const SpringNetwork& network);

/// Largest stable step of an oscillator [s]: of the reference, else of the model.
double scalar_limit(const IntegratorInfo& scheme, double omega, double damping_ratio);

/// Returns the limit of a network whose damping is `relaxation` times its stiffness: the minimum
/// over its modes, and the mode that determines it.
struct NetworkLimit {
  double h = 0.0;              ///< [s]
  double omega = 0.0;          ///< angular frequency of the mode that is unstable first
  double damping_ratio = 0.0;  ///< of that mode
};
NetworkLimit network_limit(const IntegratorInfo& scheme, const Spectrum& spectrum,
                           double relaxation);

/// Returns the growth per step of an oscillator under a scheme (spectral radius).
double growth_per_step(const IntegratorInfo& scheme, double omega, double damping_ratio, double h);

/// Quadratic form a x^2 + 2 b x v + c v^2 that a scheme conserves exactly on x'' + x = 0 at step z,
/// for the velocity that the model reports; the energy for schemes without such a form.
Eigen::Matrix2d invariant_form(const IntegratorInfo& scheme, double z);

/// Largest energy over the initial one for the worst initial state; 1 if no step gains energy.
double energy_ratio_bound(const IntegratorInfo& scheme, double z);

/// Returns the largest energy of a run over the initial one; NaN if it diverged or a value is NaN.
double energy_growth(const Trace& motion);

/// Returns the margin 20 log10(limit / used) [dB].
double margin_db(double limit, double used);

}  // namespace palpate::stability
