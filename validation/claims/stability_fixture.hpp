// SPDX-License-Identifier: MIT
#pragma once
/// Test fixture of the group "stability": small networks, their exact spectra, and theoretical
/// limits.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "model/problem/spring_network.hpp"
#include "model/stepping/integrator.hpp"
#include "validation/case.hpp"
#include "validation/random.hpp"

namespace palpate::stability {

/// Returns n^3 nodes of 1 g, 5 mm apart, 26 neighbours of 50 N/m, the far face fixed. Every
/// viscosity is `relaxation` [s] times the stiffness, so damping is proportional and modes are
/// decoupled.
SpringNetwork cube(int n, double relaxation);

/// Gives every free node a random displacement of up to `amplitude` [m].
void displace(SpringNetwork& network, double amplitude, std::uint64_t seed = 1);

/// Returns the exact angular frequencies about the initial state [rad/s], ascending, and the rates
/// of M^-1 C [1/s].
struct Spectrum {
  Eigen::VectorXd omega{};
  double damping_maximum = 0.0;
};
Spectrum spectrum_of(const SpringNetwork& network);

/// Returns the largest stable step [s] of one oscillator: from the reference if it provides the
/// scheme, else from the model.
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

/// Returns the largest energy over the initial energy of that oscillator for the worst initial
/// state; 1 if no step gains energy.
double energy_ratio_bound(const IntegratorInfo& scheme, double z);

/// Returns the coordinates with every spring at its rest length [m].
Eigen::VectorXd rest_position(const SpringNetwork& network);

/// Returns the margin 20 log10(limit / used) [dB].
double margin_db(double limit, double used);

// Cases of group "stability" by subject. Each function appends its cases.

void add_blow_up_cases(std::vector<Case>& cases);   ///< step at which a lattice becomes unstable
void add_bound_cases(std::vector<Case>& cases);     ///< guaranteed bounds against exact spectra
void add_map_cases(std::vector<Case>& cases);       ///< growth over step and damping, per scheme
void add_contrast_cases(std::vector<Case>& cases);  ///< stiffness and mass over six decades
void add_abuse_cases(std::vector<Case>& cases);     ///< zero length, inversion, huge forces, NaN
void add_step_cases(std::vector<Case>& cases);      ///< random and zero steps
void add_denormal_cases(std::vector<Case>& cases);  ///< amplitudes below the normal range
void add_drift_cases(std::vector<Case>& cases);     ///< ten million steps without damping

}  // namespace palpate::stability
