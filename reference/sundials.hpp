// SPDX-License-Identifier: MIT
#pragma once
/// What the CVODE and ARKODE solvers share: owned handles, callbacks, checked flags. Private to
/// reference/*.cpp; no other header of this library shows a library type.

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

#include "reference/first_order.hpp"
#include "reference/march.hpp"

namespace palpate::reference::sundials {

template <auto destroy>
struct Deleter {
  template <class Handle>
  void operator()(Handle* handle) const {
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

/// The system, its state vector and its tolerances, as user data of the callbacks below.
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

  /// KLU with the analytic Jacobian; the matrix lives as long as the session.
  void use_sparse_jacobian();
  [[nodiscard]] SUNMatrix matrix() const { return matrix_.get(); }
  [[nodiscard]] SUNLinearSolver linear_solver() const { return linear_solver_.get(); }

  /// Throws SolverError when flag < 0, naming the flag by the library's own function.
  void check(int flag, const char* function, char* (*flag_name)(long), double time) const;
  /// Throws SolverError when a handle could not be made.
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
  std::string cause_;      ///< why a callback refused
};

}  // namespace palpate::reference::sundials
