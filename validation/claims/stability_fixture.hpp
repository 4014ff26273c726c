// SPDX-License-Identifier: MIT
#pragma once
/// Test fixture of group "stability": small networks, exact spectra, theoretical limits.

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>

#include "model/problem/problem.hpp"
#include "model/problem/spring_network.hpp"
#include "model/stepping/integrator.hpp"
#include "model/stepping/stability.hpp"
#include "model/tissue/lattice.hpp"
#include "reference/modal.hpp"
#include "reference/oscillator.hpp"
#include "validation/claims/network_fixture.hpp"

namespace palpate::stability {

/// Returns n^3 nodes of 1 g, 5 mm apart, 26 neighbours of 50 N/m, the far face fixed. Damping is
/// proportional: every viscosity is `relaxation` [s] times the stiffness.
inline SpringNetwork cube(int n, double relaxation) {
  constexpr double stiffness = 50.0;
  const LatticeShape shape{{n, n, n}, 0.005, 26};
  SpringNetwork network = uniform_lattice(shape, stiffness, relaxation * stiffness, 1e-3);
  for (int i = (n - 1) * n * n; i < n * n * n; ++i) {
    network.fixed[static_cast<std::size_t>(i)] = 1;
  }
  return network;
}

using networks::automatic_scene;
using networks::displace;

inline bool reference_knows(const IntegratorInfo& scheme) {
  return std::ranges::find(reference::discrete_schemes(), scheme.name) !=
         reference::discrete_schemes().end();
}

/// Exact angular frequencies about the initial state [rad/s], ascending, and rates of M^-1 C [1/s].
struct Spectrum {
  Eigen::VectorXd omega{};
  double damping_maximum = 0.0;
};
inline Spectrum spectrum_of(const SpringNetwork& network) {
  const NetworkProblem problem(network);
  Eigen::SparseMatrix<double> stiffness;
  Eigen::SparseMatrix<double> damping;
  problem.jacobian(problem.initial_position(), Eigen::VectorXd::Zero(problem.dof()), stiffness,
                   damping);
  return {networks::eigenvalues(stiffness, problem.mass()).cwiseMax(0.0).cwiseSqrt(),
          networks::eigenvalues(damping, problem.mass()).maxCoeff()};
}

/// Largest stable step of an oscillator [s]: of the reference, else of the model.
inline double scalar_limit(const IntegratorInfo& scheme, double omega, double damping_ratio) {
  return reference_knows(scheme) ? reference::stability_limit(scheme.name, omega, damping_ratio)
                                 : stable_step(scheme, omega, 2.0 * damping_ratio * omega);
}

/// Returns the limit of a network whose damping is `relaxation` times its stiffness: the minimum
/// over its modes, and the mode that determines it.
struct NetworkLimit {
  double h = 0.0;              ///< [s]
  double omega = 0.0;          ///< angular frequency of the mode that is unstable first
  double damping_ratio = 0.0;  ///< of that mode
};
inline NetworkLimit network_limit(const IntegratorInfo& scheme, const Spectrum& spectrum,
                                  double relaxation) {
  NetworkLimit limit{std::numeric_limits<double>::infinity(), 0.0, 0.0};
  double last = -1.0;
  for (const double omega : spectrum.omega) {
    if (omega - last <= 1e-9 * omega || omega <= 0.0) { continue; }  // a multiple eigenvalue
    last = omega;
    const double ratio = 0.5 * relaxation * omega;
    const double h = scalar_limit(scheme, omega, ratio);
    if (h <= limit.h * (1.0 + 1e-12)) { limit = {h, omega, ratio}; }  // of equals the fastest
  }
  return limit;
}

/// Returns the growth per step of an oscillator under a scheme (spectral radius).
inline double growth_per_step(const IntegratorInfo& scheme, double omega, double damping_ratio,
                              double h) {
  const double damping = 2.0 * damping_ratio * omega;
  if (!reference_knows(scheme)) { return amplification(scheme, omega, damping, h); }
  const Oscillator unit_mass{.mass = 1.0, .stiffness = omega * omega, .viscosity = damping};
  return static_cast<double>(
      reference::spectral_radius(reference::amplification(scheme.name, unit_mass, h)));
}

/// Quadratic form a x^2 + 2 b x v + c v^2 that a scheme conserves exactly on x'' + x = 0 at step z,
/// for the velocity that the model reports; the energy for schemes without such a form.
inline Eigen::Matrix2d invariant_form(const IntegratorInfo& scheme, double z) {
  if (!reference_knows(scheme)) { return Eigen::Matrix2d::Identity(); }
  // Undamped, the mean of two half-step velocities is the velocity of velocity Verlet.
  const std::string_view name =
      reference::velocity_is_staggered(scheme.name) ? "velocity-verlet" : scheme.name;
  const Oscillator unit{.mass = 1.0, .stiffness = 1.0, .viscosity = 0.0};
  const Eigen::Matrix2d a = reference::amplification(name, unit, z).cast<double>();
  if (std::abs(a.determinant() - 1.0) > 1e-14 || std::abs(a.trace()) >= 2.0) {
    return Eigen::Matrix2d::Identity();
  }
  Eigen::Matrix2d form;
  form << -a(1, 0), 0.5 * (a(0, 0) - a(1, 1)), 0.5 * (a(0, 0) - a(1, 1)), a(0, 1);
  return form / z;
}

/// Largest energy over the initial one for the worst initial state; 1 if no step gains energy.
inline double energy_ratio_bound(const IntegratorInfo& scheme, double z) {
  const Eigen::VectorXd values = reference::symmetric_eigenvalues(invariant_form(scheme, z));
  return values(1) / values(0);
}

/// Returns the largest energy of a run over the initial one; NaN if it diverged or a value is NaN.
inline double energy_growth(const Trace& motion) {
  const std::vector<double>& energy = motion.values("energy_j");
  Largest growth(motion.diverged ? std::nan("") : 0.0);
  for (const double e : energy) { growth.add(e / energy.front()); }
  return growth.value();
}

/// Returns the margin 20 log10(limit / used) [dB].
inline double margin_db(double limit, double used) { return 20.0 * std::log10(limit / used); }

}  // namespace palpate::stability
