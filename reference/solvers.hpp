// SPDX-License-Identifier: MIT
#pragma once
/// Linear multistep references of variable order and step (CVODE), restarted at every break.

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "reference/solution.hpp"

namespace palpate::reference {

/// Solves by Adams-Moulton up to order 12 with fixed-point iteration, for problems that are not
/// stiff.
Trace solve_cvode_adams(const Problem& problem, const std::vector<double>& times,
                        const Tolerance& tolerance);

/// Solves by backward differentiation up to order 5, Newton with the analytic Jacobian and KLU.
Trace solve_cvode_bdf(const Problem& problem, const std::vector<double>& times,
                      const Tolerance& tolerance);

// One-step references (ARKODE), restarted at every break. Each run checks which table ARKODE used
// and rejects one that would reuse a stale stage (sundials.hpp).

/// Solves by Fehlberg's explicit pair of orders 7 and 8, preferred if the network is not stiff.
Trace solve_arkode_explicit(const Problem& problem, const std::vector<double>& times,
                            const Tolerance& tolerance);

/// Solves by Dormand and Prince's explicit pair of orders 5 and 4, which is cheaper for low
/// accuracy.
Trace solve_arkode_dormand_prince(const Problem& problem, const std::vector<double>& times,
                                  const Tolerance& tolerance);

/// Solves by a stiffly accurate ESDIRK 5(4) with seven stages, Newton with the analytic Jacobian
/// and KLU. Preferred for stiff damping or strong contrasts of stiffness.
Trace solve_arkode_esdirk(const Problem& problem, const std::vector<double>& times,
                          const Tolerance& tolerance);

// References by the GNU Scientific Library, which share only the first-order form with the other
// solvers. Errors are controlled per coordinate. Restarted at every break.

/// Largest number of states (2 x dof) for which solve_gsl_msbdf accepts its dense Jacobian.
inline constexpr Eigen::Index dense_state_limit = 600;

/// Solves by explicit Runge-Kutta Prince-Dormand 8(9).
Trace solve_gsl_rk8pd(const Problem& problem, const std::vector<double>& times,
                      const Tolerance& tolerance);

/// Solves by multistep BDF in Nordsieck form with the dense analytic Jacobian. Throws SolverError
/// above dense_state_limit.
Trace solve_gsl_msbdf(const Problem& problem, const std::vector<double>& times,
                      const Tolerance& tolerance);

// One-step references (Boost.odeint), restarted at every break.

/// Solves by Dormand and Prince's explicit pair of orders 5 and 4 with the library's step control.
Trace solve_odeint_dormand_prince(const Problem& problem, const std::vector<double>& times,
                                  const Tolerance& tolerance);

// Independent second implementation of the equations of motion in long double, from the physics and
// not from the specification, which reveals an error in Problem::force. Fehlberg 7(8) of
// Boost.odeint.

/// Solves a NetworkProblem or an OscillatorProblem with the corrected equations; throws SolverError
/// for any other. Printed forms of the equations are not implemented here, so results for them
/// disagree.
Trace solve_long_double(const Problem& problem, const std::vector<double>& times,
                        const Tolerance& tolerance);

// List of all solvers of this library by name and family. Two solvers of one family do not confirm
// each other.

struct NamedSolver {
  std::string name{};  ///< as in Trace::solver
  std::string
      family{};  ///< "explicit runge-kutta", "adams", "bdf", "implicit runge-kutta", "modal"
  Solver solve = nullptr;
};

const std::vector<NamedSolver>& all_solvers();

/// Returns the solver of this name. Throws std::invalid_argument with the existing names if there
/// is none.
const NamedSolver& solver_named(std::string_view name);

}  // namespace palpate::reference
