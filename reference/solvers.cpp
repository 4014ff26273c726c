// SPDX-License-Identifier: MIT

#include "reference/solvers.hpp"

#include <stdexcept>

#include "reference/modal.hpp"

namespace palpate::reference {

const std::vector<NamedSolver>& all_solvers() {
  static const std::vector<NamedSolver> solvers{
      {"arkode-fehlberg-7-8", "explicit runge-kutta", solve_arkode_explicit},
      {"arkode-dormand-prince-5-4", "explicit runge-kutta", solve_arkode_dormand_prince},
      {"cvode-adams", "adams", solve_cvode_adams},
      {"arkode-esdirk-5-4", "implicit runge-kutta", solve_arkode_esdirk},
      {"cvode-bdf", "bdf", solve_cvode_bdf},
      {"gsl-rk8pd", "explicit runge-kutta", solve_gsl_rk8pd},
      {"odeint-dormand-prince-5-4", "explicit runge-kutta", solve_odeint_dormand_prince},
      {"gsl-msbdf", "bdf", solve_gsl_msbdf},
      {"long-double-fehlberg-7-8", "explicit runge-kutta", solve_long_double},
      {"modal", "modal", solve_modal},
      {"modal-long-double", "modal", solve_modal_long_double},
  };
  return solvers;
}

const NamedSolver& solver_named(std::string_view name) {
  std::string known;
  for (const NamedSolver& solver : all_solvers()) {
    if (solver.name == name) { return solver; }
    known += (known.empty() ? "" : ", ") + solver.name;
  }
  throw std::invalid_argument("no reference solver named " + std::string(name) + "; there are " +
                              known);
}

}  // namespace palpate::reference
