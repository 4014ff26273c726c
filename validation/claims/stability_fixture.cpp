// SPDX-License-Identifier: MIT

#include "validation/claims/stability_fixture.hpp"

#include <Eigen/LU>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>

#include "model/problem/problem.hpp"
#include "model/stepping/stability.hpp"
#include "model/tissue/lattice.hpp"
#include "reference/modal.hpp"
#include "reference/oscillator.hpp"

namespace palpate::stability {

namespace {

using Eigen::VectorXd;

bool reference_knows(const IntegratorInfo& scheme) {
  return std::ranges::find(reference::discrete_schemes(), scheme.name) !=
         reference::discrete_schemes().end();
}

}  // namespace

SpringNetwork cube(int n, double relaxation) {
  constexpr double stiffness = 50.0;
  const LatticeShape shape{{n, n, n}, 0.005, 26};
  SpringNetwork network = uniform_lattice(shape, stiffness, relaxation * stiffness, 1e-3);
  for (int i = (n - 1) * n * n; i < n * n * n; ++i) {
    network.fixed[static_cast<std::size_t>(i)] = 1;
  }
  return network;
}

Spectrum spectrum_of(const SpringNetwork& network) {
  const NetworkProblem problem(network);
  Eigen::SparseMatrix<double> stiffness;
  Eigen::SparseMatrix<double> damping;
  problem.jacobian(problem.initial_position(), VectorXd::Zero(problem.dof()), stiffness, damping);
  return {networks::eigenvalues(stiffness, problem.mass()).cwiseMax(0.0).cwiseSqrt(),
          networks::eigenvalues(damping, problem.mass()).maxCoeff()};
}

double scalar_limit(const IntegratorInfo& scheme, double omega, double damping_ratio) {
  return reference_knows(scheme) ? reference::stability_limit(scheme.name, omega, damping_ratio)
                                 : stable_step(scheme, omega, 2.0 * damping_ratio * omega);
}

NetworkLimit network_limit(const IntegratorInfo& scheme, const Spectrum& spectrum,
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

double growth_per_step(const IntegratorInfo& scheme, double omega, double damping_ratio, double h) {
  const double damping = 2.0 * damping_ratio * omega;
  if (!reference_knows(scheme)) { return amplification(scheme, omega, damping, h); }
  const Oscillator unit_mass{.mass = 1.0, .stiffness = omega * omega, .viscosity = damping};
  return static_cast<double>(
      reference::spectral_radius(reference::amplification(scheme.name, unit_mass, h)));
}

Eigen::Matrix2d invariant_form(const IntegratorInfo& scheme, double z) {
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

double energy_ratio_bound(const IntegratorInfo& scheme, double z) {
  const VectorXd values = reference::symmetric_eigenvalues(invariant_form(scheme, z));
  return values(1) / values(0);
}

double energy_growth(const Trace& motion) {
  const std::vector<double>& energy = motion.values("energy_j");
  Largest growth(motion.diverged ? std::nan("") : 0.0);
  for (const double e : energy) { growth.add(e / energy.front()); }
  return growth.value();
}

double margin_db(double limit, double used) { return 20.0 * std::log10(limit / used); }

}  // namespace palpate::stability
