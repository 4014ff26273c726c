// SPDX-License-Identifier: MIT
#pragma once
/// What the cases of group "stability" share: small networks, their exact spectra, and the limits
/// that theory gives for them.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "model/problem/spring_network.hpp"
#include "model/stepping/integrator.hpp"
#include "validation/case.hpp"
#include "validation/random.hpp"

namespace palpate::stability {

/// n^3 nodes of 1 g, 5 mm apart, 26 neighbours of 50 N/m, the far face held. Every viscosity is
/// `relaxation` [s] times the stiffness, so damping is proportional and modes decouple.
SpringNetwork cube(int n, double relaxation);

/// Gives every free node a random displacement of up to `amplitude` [m].
void displace(SpringNetwork& network, double amplitude, std::uint64_t seed = 1);

/// Exact angular frequencies about the initial state [rad/s], ascending, and rates of M^-1 C [1/s].
struct Spectrum {
  Eigen::VectorXd omega{};
  double damping_maximum = 0.0;
};
Spectrum spectrum_of(const SpringNetwork& network);

/// Largest h [s] that one oscillator bears: the reference's where it knows the scheme, else the
/// model's own.
double scalar_limit(const IntegratorInfo& scheme, double omega, double damping_ratio);

/// The same for a network whose damping is `relaxation` times its stiffness: the least over its
/// modes, and the mode that sets it.
struct NetworkLimit {
  double h = 0.0;              ///< [s]
  double omega = 0.0;          ///< of the mode that fails first [rad/s]
  double damping_ratio = 0.0;  ///< of that mode
};
NetworkLimit network_limit(const IntegratorInfo& scheme, const Spectrum& spectrum,
                           double relaxation);

/// Growth per step of an oscillator under a scheme (spectral radius).
double growth_per_step(const IntegratorInfo& scheme, double omega, double damping_ratio, double h);

/// Quadratic form a x^2 + 2 b x v + c v^2 that a scheme keeps exactly on x'' + x = 0 at step z, for
/// the velocity that the model reports; the energy itself for schemes that keep no form.
Eigen::Matrix2d invariant_form(const IntegratorInfo& scheme, double z);

/// Largest energy over the initial one on that oscillator, for the worst start: 1 where no step
/// gains energy.
double energy_ratio_bound(const IntegratorInfo& scheme, double z);

/// Positions of the coordinates with every spring at rest [m].
Eigen::VectorXd rest_position(const SpringNetwork& network);

/// 20 log10(limit / used).
double margin_db(double limit, double used);

// The cases of group "stability", by subject. Each function appends its own.

void add_blow_up_cases(std::vector<Case>& cases);   ///< the step at which a lattice blows up
void add_bound_cases(std::vector<Case>& cases);     ///< guaranteed bounds against exact spectra
void add_map_cases(std::vector<Case>& cases);       ///< growth over step and damping, per scheme
void add_contrast_cases(std::vector<Case>& cases);  ///< stiffness and mass over six decades
void add_abuse_cases(std::vector<Case>& cases);     ///< zero length, inversion, huge forces, NaN
void add_step_cases(std::vector<Case>& cases);      ///< random and zero steps
void add_denormal_cases(std::vector<Case>& cases);  ///< amplitudes below the normal range
void add_drift_cases(std::vector<Case>& cases);     ///< ten million steps without damping

}  // namespace palpate::stability
