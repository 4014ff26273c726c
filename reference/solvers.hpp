// SPDX-License-Identifier: MIT
#pragma once
/// Linear multistep references of variable order and step (CVODE). Restarted at every break.

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "reference/solution.hpp"

namespace palpate::reference {

/// Adams-Moulton up to order 12, fixed-point iteration: for problems that are not stiff.
Trace solve_cvode_adams(const Problem& problem, const std::vector<double>& times,
                        const Tolerance& tolerance);

/// Backward differentiation up to order 5, Newton with the analytic Jacobian and KLU.
Trace solve_cvode_bdf(const Problem& problem, const std::vector<double>& times,
                      const Tolerance& tolerance);

// One-step references (ARKODE). Restarted at every break. Tables: runge_kutta_table.hpp; each run
// asks ARKODE which one it used and refuses one that would reuse a stale stage.

/// Fehlberg's explicit pair of orders 7 and 8: the first choice when the network is not stiff.
Trace solve_arkode_explicit(const Problem& problem, const std::vector<double>& times,
                            const Tolerance& tolerance);

/// Dormand and Prince's explicit pair of orders 5 and 4: for low accuracy, where it is cheaper.
Trace solve_arkode_dormand_prince(const Problem& problem, const std::vector<double>& times,
                                  const Tolerance& tolerance);

/// Stiffly accurate ESDIRK 5(4) with seven stages, Newton with the analytic Jacobian and KLU: the
/// first choice for stiff damping or strong contrasts of stiffness.
Trace solve_arkode_esdirk(const Problem& problem, const std::vector<double>& times,
                          const Tolerance& tolerance);

// References by the GNU Scientific Library: nothing in common with the other solvers but the
// first-order form. Errors are controlled per coordinate. Restarted at every break.

/// Most states (2 x dof) for which the dense Jacobian of solve_gsl_msbdf is accepted.
inline constexpr Eigen::Index dense_state_limit = 600;

/// Explicit Runge-Kutta Prince-Dormand 8(9).
Trace solve_gsl_rk8pd(const Problem& problem, const std::vector<double>& times,
                      const Tolerance& tolerance);

/// Multistep BDF in Nordsieck form with the dense analytic Jacobian; SolverError above the limit.
Trace solve_gsl_msbdf(const Problem& problem, const std::vector<double>& times,
                      const Tolerance& tolerance);

// One-step references (Boost.odeint). Restarted at every break.

/// Dormand and Prince's explicit pair of orders 5 and 4, with the library's own control of the
/// step.
Trace solve_odeint_dormand_prince(const Problem& problem, const std::vector<double>& times,
                                  const Tolerance& tolerance);

// The equations of motion written a second time, in long double, from the physics and not from the
// specification: an error in Problem::force shows as disagreement. Fehlberg 7(8) of Boost.odeint.

/// For a NetworkProblem or an OscillatorProblem, with the corrected equations; SolverError for any
/// other. The printed forms of the equations are not known here, and disagree, as they should.
Trace solve_long_double(const Problem& problem, const std::vector<double>& times,
                        const Tolerance& tolerance);

// All solvers of this library by name and family. Two solvers of one family do not confirm each
// other.

struct NamedSolver {
  std::string name{};  ///< as in Trace::solver
  std::string
      family{};  ///< "explicit runge-kutta", "adams", "bdf", "implicit runge-kutta", "modal"
  Solver solve = nullptr;
};

const std::vector<NamedSolver>& all_solvers();

/// std::invalid_argument, naming those that exist, when there is none of that name.
const NamedSolver& solver_named(std::string_view name);

}  // namespace palpate::reference
