// SPDX-License-Identifier: MIT
#pragma once
/// Eigenvalues of small dense matrices by GSL, and exact modal solutions of linear problems. All
/// functions throw SolverError if GSL does not converge.

#include <Eigen/Core>
#include <vector>

#include "reference/solution.hpp"

namespace palpate::reference {

struct SymmetricModes {
  Eigen::VectorXd values{};   ///< ascending
  Eigen::MatrixXd vectors{};  ///< one column each, orthonormal
};

/// Computes the modes of a symmetric matrix; only its lower half is read.
SymmetricModes symmetric_modes(const Eigen::MatrixXd& matrix);
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& matrix);

struct GeneralModes {
  Eigen::VectorXcd values{};   ///< unordered
  Eigen::MatrixXcd vectors{};  ///< one column each, of unit length
};

/// Computes the modes of any real matrix.
GeneralModes general_modes(const Eigen::MatrixXd& matrix);

// Exact motion of one mode under a force of known shape: eta'' + 2 gamma eta' + omega^2 eta = p(t),
//   p(t) = constant + slope t + sum of cosine_k cos(w_k t) + sine_k sin(w_k t).
// Free motion in closed form for every sign of omega^2 - gamma^2, omega = 0 included. Forced
// motion by its particular solution, or, near resonance and for omega near 0 where that cancels,
// by the exponential of the mode and its force taken as one small linear system.

template <class Real> struct ModeState {
  Real position{};
  Real velocity{};
};

template <class Real> struct ModeForce {
  struct Harmonic {
    Real frequency{};  ///< [rad/s]
    Real cosine{};
    Real sine{};
  };
  Real constant{};
  Real slope{};
  std::vector<Harmonic> harmonics{};
};

template <class Real> struct Mode {
  Real omega_squared{};  ///< negative for an unstable mode [rad^2/s^2]
  Real gamma{};          ///< [1/s]
};

template <class Real>
ModeState<Real> free_response(const Mode<Real>& mode, const ModeState<Real>& initial, Real t);

/// Returns the state at time t [s] after `initial` at time 0. Defined for double and long double.
template <class Real>
ModeState<Real> respond(const Mode<Real>& mode, const ModeState<Real>& initial,
                        const ModeForce<Real>& force, Real t);

// Exact motion of the linearised problem by superposition of its modes.

/// Returns the natural angular frequencies of the undamped linearised problem [rad/s], ascending; 0
/// for rigid motions and for unstable directions.
Eigen::VectorXd natural_frequencies(const Problem& problem);

/// Returns the motion of LinearProblem(problem), exact to rounding: constant, ramp, half-sine and
/// cosine loads have closed forms per mode and segment. The
/// decomposition and the sums are in double or in long double. Throws SolverError if the modes of K
/// do not diagonalise C to 1e-9 of its largest entry, if K is not symmetric, or if the loads have
/// no known closed form. The tolerance is ignored.
Solve solve_modal;
Solve solve_modal_long_double;

}  // namespace palpate::reference
