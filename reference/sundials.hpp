// SPDX-License-Identifier: MIT
#pragma once
/// Owned handles, callbacks and flag checks of the CVODE and ARKODE solvers. Private to
/// reference/*.cpp; no other header of this library exposes a library type.

// clang-format off
#include <cstdio>  // arkode_butcher.h uses FILE
#include <arkode/arkode_butcher.h>
// clang-format on
#include <exception>
#include <memory>
#include <nvector/nvector_serial.h>
#include <optional>
#include <string>
#include <sundials/sundials_context.h>
#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>
#include <sundials/sundials_nonlinearsolver.h>
#include <type_traits>

#include "reference/integrate.hpp"

namespace palpate::reference::sundials {

template <auto destroy> struct Deleter {
  template <class Handle> void operator()(Handle* handle) const {
    if constexpr (std::is_invocable_v<decltype(destroy), Handle*>) {
      destroy(handle);
    } else {
      destroy(&handle);
    }
  }
};
template <class Handle, auto destroy>
using Owned = std::unique_ptr<std::remove_pointer_t<Handle>, Deleter<destroy>>;

using Context = Owned<SUNContext, SUNContext_Free>;
using Vector = Owned<N_Vector, N_VDestroy>;
using Matrix = Owned<SUNMatrix, SUNMatDestroy>;
using LinearSolver = Owned<SUNLinearSolver, SUNLinSolFree>;
using NonlinearSolver = Owned<SUNNonlinearSolver, SUNNonlinSolFree>;

std::string version();  ///< "SUNDIALS 6.4.1"

/// System, state vector and tolerances, passed as user data to the callbacks below.
class Session {
 public:
  Session(std::string solver, const Problem& problem, const Tolerance& tolerance);
  Session(const Session&) = delete;  // the libraries keep its address
  Session& operator=(const Session&) = delete;

  [[nodiscard]] FirstOrderSystem& system() { return system_; }
  [[nodiscard]] const std::string& solver() const { return solver_; }
  [[nodiscard]] SUNContext context() const { return context_.get(); }
  [[nodiscard]] N_Vector state() const { return state_.get(); }
  [[nodiscard]] const double* state_values() const { return N_VGetArrayPointer(state_.get()); }
  [[nodiscard]] N_Vector absolute_tolerance() const { return absolute_.get(); }

  /// Uses KLU with the analytic Jacobian; the matrix is owned by the session.
  void use_sparse_jacobian();
  [[nodiscard]] SUNMatrix matrix() const { return matrix_.get(); }
  [[nodiscard]] SUNLinearSolver linear_solver() const { return linear_solver_.get(); }

  /// Throws SolverError if flag < 0, with the flag's name from the library.
  void check(int flag, const char* function, char* (*flag_name)(long), double time) const;
  /// Throws SolverError if a handle could not be created.
  void check_made(const void* handle, const char* function) const;

  static int right_hand_side(realtype t, N_Vector y, N_Vector dy, void* session);
  static int jacobian(realtype t, N_Vector y, N_Vector dy, SUNMatrix matrix, void* session,
                      N_Vector, N_Vector, N_Vector);
  static void complain(int code, const char* module, const char* function, char* message,
                       void* session);

 private:
  std::string solver_;
  FirstOrderSystem system_;
  Context context_;
  Vector state_;
  Vector absolute_;
  std::optional<FirstOrderJacobian> jacobian_;
  Matrix matrix_;
  LinearSolver linear_solver_;
  std::string complaint_;  ///< last message of the library
  std::string cause_;      ///< reason of a failure in a callback
};

// Runge-Kutta tables that ERKStep and ARKStep of SUNDIALS 6.4 integrate correctly.
//
// Those steppers reuse the last stage's derivative as the first one of the next step whenever the
// last stage's time is the end of the step, without asking whether its value is the new solution
// (fixed upstream in 2023). Heun-Euler then has one evaluation per step instead of two, Verner
// 8-5-6 drops from order 6 to 3 and Fehlberg 13-7-8 from order 8 to 7. A table is safe when its
// last stage is not at the end of the step, or when its last row is the solution row; any other
// is made safe by one more, unused, stage at the beginning of the step.
// The library's header uses FILE and leaves it to others to declare it first.
using Table = std::unique_ptr<ARKodeButcherTableMem, Deleter<ARKodeButcherTable_Free>>;

/// Returns true if the last stage's derivative is not reused or if reusing it is correct.
bool reuses_no_stale_stage(const ARKodeButcherTableMem& table);

/// Checks the table that a stepper used. Throws SolverError that names `solver` if the table reuses
/// a stale stage.
void refuse_stale_stage(ARKodeButcherTable used, const std::string& solver);

/// Returns the same method, with an additional stage if needed.
Table without_stale_stage(const ARKodeButcherTableMem& table);

Table explicit_table(int id);  ///< ARKODE_ERKTableID, made safe
Table implicit_table(int id);  ///< ARKODE_DIRKTableID; SolverError when it is not safe

}  // namespace palpate::reference::sundials
