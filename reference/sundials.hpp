// SPDX-License-Identifier: MIT
#pragma once
/// Owned handles, callbacks and flag checks of the CVODE and ARKODE solvers. Private to
/// reference/*.cpp; no other header of this library exposes a library type.

// clang-format off
#include <cstdio>  // arkode_butcher.h uses FILE
#include <arkode/arkode_butcher.h>
// clang-format on
#include <cvode/cvode.h>
#include <exception>
#include <functional>
#include <memory>
#include <nvector/nvector_serial.h>
#include <string>
#include <sundials/sundials_context.h>
#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>
#include <sundials/sundials_nonlinearsolver.h>
#include <type_traits>
#include <vector>

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

/// State, tolerances and callbacks of an integrator of y' = rate(t, y).
class Session {
 public:
  /// Computes y'. Returns false if a component is not finite.
  using Rate = std::function<bool(double t, const double* y, double* dy)>;

  /// `prefix` and `flag_name` are those of the library: "CVode", CVodeGetReturnFlagName.
  Session(std::string solver, const char* prefix, char* (*flag_name)(long),
          const Eigen::VectorXd& start, const Eigen::VectorXd& absolute, Rate rate);
  Session(const Session&) = delete;  // the libraries keep its address
  Session& operator=(const Session&) = delete;

  [[nodiscard]] const double* values() const { return N_VGetArrayPointer(state_.get()); }

 protected:
  [[nodiscard]] SUNContext context() const { return context_.get(); }
  [[nodiscard]] N_Vector vector() const { return state_.get(); }
  [[nodiscard]] N_Vector absolute_tolerance() const { return absolute_.get(); }

  /// Creates KLU and the matrix for the analytic Jacobian of a system, which must outlive this.
  void use_sparse_jacobian(const FirstOrderSystem& system);
  [[nodiscard]] SUNMatrix matrix() const { return matrix_.get(); }
  [[nodiscard]] SUNLinearSolver linear_solver() const { return linear_solver_.get(); }

  /// Throws SolverError with the name of the flag if flag < 0; `function` has no prefix.
  void check(int flag, const std::string& function) const;
  /// Throws SolverError if a handle could not be created.
  void check_made(const void* handle, const char* function) const;

  static int right_hand_side(realtype t, N_Vector y, N_Vector dy, void* session);
  static int jacobian(realtype t, N_Vector y, N_Vector dy, SUNMatrix matrix, void* session,
                      N_Vector, N_Vector, N_Vector);
  static void complain(int code, const char* module, const char* function, char* message,
                       void* session);
  /// Runs a callback and keeps the message of an exception; returns 0, or -1 if it failed.
  template <class Work> int guarded(Work&& work) {
    try {
      return work() ? 0 : -1;
    } catch (const std::exception& error) { cause_ = error.what(); }
    return -1;
  }

  std::string solver_;
  double time_ = 0.0;  ///< [s]

 private:
  const char* prefix_;
  char* (*flag_name_)(long);
  Rate rate_;
  Context context_;
  Vector state_;
  Vector absolute_;
  const FirstOrderSystem* jacobian_of_ = nullptr;
  Matrix matrix_;
  LinearSolver linear_solver_;
  std::string complaint_;  ///< last message of the library
  std::string cause_;      ///< reason of a failure in a callback
};

/// Multistep integrator with root finding.
class Cvode : public Session {
 public:
  /// Values of the root functions at a state.
  using Roots = std::function<void(double t, const double* y, double* values)>;

  /// CV_ADAMS: orders up to 12 with fixed-point iteration. CV_BDF: orders up to 5 with Newton
  /// iteration and the analytic Jacobian of `system`.
  Cvode(std::string solver, int method, const Eigen::VectorXd& start, double relative,
        const Eigen::VectorXd& absolute, Rate rate, const FirstOrderSystem* system = nullptr);
  /// Restarts at `start` [s] from the present values, or from y; never integrates beyond `stop`.
  void restart(double start, double stop, double longest_step);
  void restart(double start, double stop, double longest_step, const Eigen::VectorXd& y);
  /// Integrates to `goal` [s] or to the first root; returns true at a root.
  bool evolve(double goal);
  [[nodiscard]] double time() const { return time_; }  ///< [s]
  [[nodiscard]] long steps() const;                    ///< since the last restart
  /// Sets root functions of which only downward zero crossings end an integration.
  void set_falling_roots(std::size_t count, Roots roots);
  /// Returns the numbers of the roots that evolve() found.
  [[nodiscard]] std::vector<std::size_t> found_roots() const;

 private:
  static int root_values(realtype t, N_Vector y, realtype* values, void* session);

  NonlinearSolver fixed_point_;
  std::unique_ptr<void, Deleter<CVodeFree>> memory_;  ///< freed before what it points to
  std::size_t root_count_ = 0;
  Roots roots_{};
};

// Runge-Kutta tables that ERKStep and ARKStep of SUNDIALS 6.4 integrate correctly.
//
// Those steppers reuse the last stage's derivative as the first one of the next step whenever the
// last stage's time is the end of the step, without asking whether its value is the new solution
// (fixed upstream in 2023). Heun-Euler then has one evaluation per step instead of two, Verner
// 8-5-6 drops from order 6 to 3 and Fehlberg 13-7-8 from order 8 to 7. A table is safe when its
// last stage is not at the end of the step, or when its last row is the solution row; any other
// is made safe by one more, unused, stage at the beginning of the step.
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
