// SPDX-License-Identifier: MIT
#pragma once
/// The equations of motion written a second time, in long double, from the physics and not from the
/// specification: an error in Problem::force shows as disagreement. Fehlberg 7(8) of Boost.odeint.

#include "reference/solution.hpp"

namespace palpate::reference {

/// For a NetworkProblem or an OscillatorProblem, with the corrected equations; SolverError for any
/// other. The printed forms of the equations are not known here, and disagree, as they should.
Solution solve_long_double(const Problem& problem, const std::vector<double>& times,
                           const Tolerance& tolerance);

}  // namespace palpate::reference
