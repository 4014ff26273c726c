// SPDX-License-Identifier: MIT
#include "reference/sundials.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <sundials/sundials_version.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_sparse.h>

namespace palpate::reference::sundials {

namespace {

Context make_context() {
  SUNContext context = nullptr;
  if (SUNContext_Create(nullptr, &context) != 0) {
    throw SolverError("SUNDIALS: SUNContext_Create failed");
  }
  return Context(context);
}

std::string at(double t) {
  char text[64];
  std::snprintf(text, sizeof text, " at t = %.9g s", t);
  return text;
}

}  // namespace

std::string version() {
  char text[32] = "";
  SUNDIALSGetVersion(text, static_cast<int>(sizeof text));
  return std::string("SUNDIALS ") + text;
}

Session::Session(std::string solver, const Problem& problem, const Tolerance& tolerance)
    : solver_(std::move(solver)), system_(problem), context_(make_context()) {
  state_.reset(N_VNew_Serial(system_.size(), context()));
  check_made(state_.get(), "N_VNew_Serial");
  absolute_.reset(N_VClone(state()));
  check_made(absolute_.get(), "N_VClone");
  system_.initial_state(N_VGetArrayPointer(state()));
  double* absolute = N_VGetArrayPointer(absolute_tolerance());
  std::fill_n(absolute, system_.dof(), tolerance.relative * tolerance.position_scale);
  std::fill_n(absolute + system_.dof(), system_.dof(),
              tolerance.relative * tolerance.velocity_scale);
}

void Session::use_sparse_jacobian() {
  jacobian_.emplace(system_);
  const auto entries = static_cast<sunindextype>(jacobian_->rows().size());
  matrix_.reset(SUNSparseMatrix(jacobian_->size(), jacobian_->size(), entries, CSC_MAT, context()));
  check_made(matrix_.get(), "SUNSparseMatrix");
  linear_solver_.reset(SUNLinSol_KLU(state(), matrix(), context()));
  check_made(linear_solver_.get(), "SUNLinSol_KLU");
  constexpr int minimum_degree = 0;  // AMD: a quarter faster than COLAMD on lattices
  if (SUNLinSol_KLUSetOrdering(linear_solver(), minimum_degree) != 0) {
    fail(solver_, "SUNLinSol_KLUSetOrdering", "an error", 0.0, "");
  }
}

void Session::check(int flag, const char* function, char* (*flag_name)(long), double time) const {
  if (flag >= 0) { return; }
  const std::unique_ptr<char, Deleter<std::free>> name(flag_name(flag));
  const std::string why =
      cause_.empty() || complaint_.empty() ? cause_ + complaint_ : cause_ + "; " + complaint_;
  fail(solver_, function, name ? name.get() : std::to_string(flag), time, why);
}

void Session::check_made(const void* handle, const char* function) const {
  if (handle == nullptr) { fail(solver_, function, "NULL", 0.0, complaint_); }
}

int Session::right_hand_side(realtype t, N_Vector y, N_Vector dy, void* session) {
  auto& self = *static_cast<Session*>(session);
  try {
    if (self.system_.derivative(t, N_VGetArrayPointer(y), N_VGetArrayPointer(dy))) { return 0; }
    self.cause_ = "the right-hand side is not finite" + at(t);
  } catch (const std::exception& error) { self.cause_ = error.what(); }
  return -1;
}

int Session::jacobian(realtype, N_Vector y, N_Vector, SUNMatrix matrix, void* session, N_Vector,
                      N_Vector, N_Vector) {
  auto& self = *static_cast<Session*>(session);
  try {
    FirstOrderJacobian& jacobian = *self.jacobian_;
    jacobian.update(N_VGetArrayPointer(y));
    // The library clears the indices too before it asks, so the pattern is written every time.
    std::ranges::copy(jacobian.column_starts(), SUNSparseMatrix_IndexPointers(matrix));
    std::ranges::copy(jacobian.rows(), SUNSparseMatrix_IndexValues(matrix));
    std::ranges::copy(jacobian.values(), SUNSparseMatrix_Data(matrix));
    return 0;
  } catch (const std::exception& error) {
    self.cause_ = error.what();
    return -1;
  }
}

void Session::complain(int code, const char*, const char* function, char* message, void* session) {
  if (code >= 0) { return; }  // a warning; what matters is checked
  static_cast<Session*>(session)->complaint_ = std::string(function) + ": " + message;
}

}  // namespace palpate::reference::sundials
