// SPDX-License-Identifier: MIT
#pragma once
/// Reference solvers of many libraries, restarted at every break.

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "reference/solution.hpp"

namespace palpate::reference {

// CVODE.

Solve solve_cvode_adams;  ///< Adams-Moulton up to order 12, for problems that are not stiff
Solve solve_cvode_bdf;    ///< BDF up to order 5, Newton with the analytic Jacobian and KLU

// ARKODE, one step. Each run checks which table ARKODE used and rejects one that would reuse a
// stale stage (sundials.hpp).

Solve solve_arkode_explicit;        ///< Fehlberg 7(8), preferred if the network is not stiff
Solve solve_arkode_dormand_prince;  ///< Dormand-Prince 5(4), cheaper for low accuracy
/// Stiffly accurate ESDIRK 5(4) with seven stages, Newton with the analytic Jacobian and KLU.
/// Preferred for stiff damping or strong contrasts of stiffness.
Solve solve_arkode_esdirk;

// GNU Scientific Library, with errors controlled per coordinate.

/// Largest number of states (2 x dof) for which solve_gsl_msbdf accepts its dense Jacobian.
inline constexpr Eigen::Index dense_state_limit = 600;

Solve solve_gsl_rk8pd;  ///< Prince-Dormand 8(9)
/// Multistep BDF in Nordsieck form with the dense analytic Jacobian. Throws SolverError above
/// dense_state_limit.
Solve solve_gsl_msbdf;

// Boost.odeint, one step, with errors controlled per coordinate.

Solve solve_odeint_dormand_prince;  ///< Dormand-Prince 5(4)
/// Fehlberg 7(8) in long double with its own equations of motion, from the physics and not from the
/// specification, which reveals an error in Problem::force. Solves a NetworkProblem or an
/// OscillatorProblem with the corrected equations; throws SolverError for any other. Printed forms
/// of the equations are not implemented here, so results for them disagree.
Solve solve_long_double;

// List of all solvers of this library by name and family. Two solvers of one family do not confirm
// each other.

struct NamedSolver {
  std::string name{};  ///< as in Trace::method
  /// "explicit runge-kutta", "adams", "bdf", "implicit runge-kutta", "modal"
  std::string family{};
  Solver solve = nullptr;
};

const std::vector<NamedSolver>& all_solvers();

/// Returns the solver of this name. Throws std::invalid_argument with the existing names if there
/// is none.
const NamedSolver& solver_named(std::string_view name);

}  // namespace palpate::reference
