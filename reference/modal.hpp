// SPDX-License-Identifier: MIT
#pragma once
/// Exact motion of the linearised problem by superposition of its modes.

#include <Eigen/Core>

#include "reference/solution.hpp"

namespace palpate::reference {

/// Natural angular frequencies of the undamped linearised problem [rad/s], ascending; 0 for rigid
/// motions and for unstable directions.
Eigen::VectorXd natural_frequencies(const Problem& problem);

/// The motion of LinearProblem(problem), exact to rounding: constant, ramp, half-sine and cosine
/// loads have closed forms per mode and segment. Real (double or long double) is the precision of
/// the decomposition and of the sums. SolverError when the modes of K do not diagonalise C to 1e-9
/// of its largest entry, when K is not symmetric, or when the loads have no known closed form.
template <class Real>
Solution modal_solution(const Problem& problem, const std::vector<double>& times);

/// The same as a Solver; there is no tolerance to choose.
Solution solve_modal(const Problem& problem, const std::vector<double>& times,
                     const Tolerance& tolerance);
Solution solve_modal_long_double(const Problem& problem, const std::vector<double>& times,
                                 const Tolerance& tolerance);

}  // namespace palpate::reference
