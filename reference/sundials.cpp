// SPDX-License-Identifier: MIT

#include "reference/sundials.hpp"

#include <Eigen/SparseCore>
#include <algorithm>
#include <arkode/arkode_arkstep.h>
#include <arkode/arkode_butcher_dirk.h>
#include <arkode/arkode_butcher_erk.h>
#include <arkode/arkode_erkstep.h>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cvode/cvode.h>
#include <cvode/cvode_ls.h>
#include <sundials/sundials_version.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_sparse.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include "reference/solvers.hpp"

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
  constexpr int minimum_degree = 0;  // AMD; faster than COLAMD on lattices
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
    // The library also clears the indices before this call, so the pattern is written every time.
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
  if (code >= 0) { return; }  // a warning; results are checked separately
  static_cast<Session*>(session)->complaint_ = std::string(function) + ": " + message;
}

namespace {

Table loaded(ARKodeButcherTable table) {
  if (table == nullptr) { throw SolverError("SUNDIALS: no such Runge-Kutta table"); }
  return Table(table);
}

}  // namespace

bool reuses_no_stale_stage(const ARKodeButcherTableMem& table) {
  const int last = table.stages - 1;
  constexpr double rounding = 1e-10;  // wider than the library's own test
  if (std::abs(table.c[last] - 1.0) > rounding) { return true; }
  for (int j = 0; j < table.stages; ++j) {
    if (std::abs(table.A[last][j] - table.b[j]) > 1e-14) { return false; }
  }
  return true;
}

void refuse_stale_stage(ARKodeButcherTable used, const std::string& solver) {
  if (used != nullptr && reuses_no_stale_stage(*used)) { return; }
  throw SolverError(solver +
                    ": SUNDIALS chose a Runge-Kutta table whose last stage it would reuse stale");
}

Table without_stale_stage(const ARKodeButcherTableMem& table) {
  const bool safe = reuses_no_stale_stage(table);
  Table copy = loaded(ARKodeButcherTable_Alloc(table.stages + (safe ? 0 : 1), table.d != nullptr));
  copy->q = table.q;
  copy->p = table.p;
  std::copy_n(table.c, table.stages, copy->c);  // the added stage keeps c = 0, A = 0, b = 0
  std::copy_n(table.b, table.stages, copy->b);
  if (table.d != nullptr) { std::copy_n(table.d, table.stages, copy->d); }
  for (int i = 0; i < table.stages; ++i) { std::copy_n(table.A[i], table.stages, copy->A[i]); }
  return copy;
}

Table explicit_table(int id) {
  const Table stock = loaded(ARKodeButcherTable_LoadERK(static_cast<ARKODE_ERKTableID>(id)));
  return without_stale_stage(*stock);
}

Table implicit_table(int id) {
  Table stock = loaded(ARKodeButcherTable_LoadDIRK(static_cast<ARKODE_DIRKTableID>(id)));
  if (!reuses_no_stale_stage(*stock)) {
    throw SolverError("SUNDIALS: this table would reuse a stale stage");
  }
  return stock;
}

}  // namespace palpate::reference::sundials

namespace palpate::reference {

namespace {

using sundials::Session;

class Cvode final : public Integrator {
 public:
  Cvode(std::string name, int multistep, const Problem& problem, const Tolerance& tolerance)
      : session_(std::move(name), problem, tolerance),
        memory_(CVodeCreate(multistep, session_.context())) {
    session_.check_made(memory_.get(), "CVodeCreate");
    check(CVodeSetErrHandlerFn(memory_.get(), Session::complain, &session_),
          "CVodeSetErrHandlerFn");
    check(CVodeInit(memory_.get(), Session::right_hand_side, 0.0, session_.state()), "CVodeInit");
    check(CVodeSetUserData(memory_.get(), &session_), "CVodeSetUserData");
    check(CVodeSVtolerances(memory_.get(), tolerance.relative, session_.absolute_tolerance()),
          "CVodeSVtolerances");
    check(CVodeSetMaxNumSteps(memory_.get(), step_limit), "CVodeSetMaxNumSteps");
    if (multistep == CV_BDF) {
      use_newton();
    } else {
      use_fixed_point();
    }
  }

  [[nodiscard]] Session& session() { return session_; }

  void begin(const Segment& segment) override {
    check(CVodeReInit(memory_.get(), segment.start, session_.state()), "CVodeReInit");
    check(CVodeSetMaxStep(memory_.get(), segment.max_step), "CVodeSetMaxStep");
    check(CVodeSetStopTime(memory_.get(), segment.end), "CVodeSetStopTime");
    // Without a minimum step, a failing right-hand side leads to millions of steps of length zero.
    check(CVodeSetMinStep(memory_.get(), 1e-14 * segment.end), "CVodeSetMinStep");
    time_ = segment.start;
  }

  /// Advances with interpolation between steps, which has the accuracy of the steps. Steps end
  /// exactly only at breaks.
  void advance(double time) override {
    const int flag = CVode(memory_.get(), time, session_.state(), &time_, CV_NORMAL);
    if (flag < 0) { CVodeGetCurrentTime(memory_.get(), &time_); }
    check(flag, "CVode");
  }

  [[nodiscard]] const double* state() const override { return session_.state_values(); }

  [[nodiscard]] long segment_steps() const override {
    long steps = 0;
    check(CVodeGetNumSteps(memory_.get(), &steps), "CVodeGetNumSteps");
    return steps;
  }

 private:
  void use_newton() {
    session_.use_sparse_jacobian();
    check(CVodeSetLinearSolver(memory_.get(), session_.linear_solver(), session_.matrix()),
          "CVodeSetLinearSolver");
    check(CVodeSetJacFn(memory_.get(), Session::jacobian), "CVodeSetJacFn");
  }

  void use_fixed_point() {
    fixed_point_.reset(SUNNonlinSol_FixedPoint(session_.state(), 0, session_.context()));
    session_.check_made(fixed_point_.get(), "SUNNonlinSol_FixedPoint");
    check(CVodeSetNonlinearSolver(memory_.get(), fixed_point_.get()), "CVodeSetNonlinearSolver");
  }

  void check(int flag, const char* function) const {
    session_.check(flag, function, CVodeGetReturnFlagName, time_);
  }

  Session session_;
  sundials::NonlinearSolver fixed_point_;
  std::unique_ptr<void, sundials::Deleter<CVodeFree>> memory_;  // freed before what it points to
  double time_ = 0.0;
};

Trace solve(const char* name, int multistep, const Problem& problem,
            const std::vector<double>& times, const Tolerance& tolerance) {
  Cvode integrator(name, multistep, problem, tolerance);
  return integrate({name, sundials::version()}, integrator.session().system(), times, tolerance,
                   integrator);
}

}  // namespace

Trace solve_cvode_adams(const Problem& problem, const std::vector<double>& times,
                        const Tolerance& tolerance) {
  return solve("cvode-adams", CV_ADAMS, problem, times, tolerance);
}

Trace solve_cvode_bdf(const Problem& problem, const std::vector<double>& times,
                      const Tolerance& tolerance) {
  return solve("cvode-bdf", CV_BDF, problem, times, tolerance);
}

namespace {

using sundials::Session;

class Explicit final : public Integrator {
 public:
  Explicit(const char* name, ARKODE_ERKTableID id, const Problem& problem,
           const Tolerance& tolerance)
      : session_(name, problem, tolerance),
        memory_(
            ERKStepCreate(Session::right_hand_side, 0.0, session_.state(), session_.context())) {
    session_.check_made(memory_.get(), "ERKStepCreate");
    void* const memory = memory_.get();
    check(ERKStepSetErrHandlerFn(memory, Session::complain, &session_), "ERKStepSetErrHandlerFn");
    check(ERKStepSetUserData(memory, &session_), "ERKStepSetUserData");
    const sundials::Table table = sundials::explicit_table(id);
    check(ERKStepSetTable(memory, table.get()), "ERKStepSetTable");
    check(ERKStepSVtolerances(memory, tolerance.relative, session_.absolute_tolerance()),
          "ERKStepSVtolerances");
    check(ERKStepSetMaxNumSteps(memory, step_limit), "ERKStepSetMaxNumSteps");
  }

  [[nodiscard]] Session& session() { return session_; }

  void begin(const Segment& segment) override {
    check(ERKStepReInit(memory_.get(), Session::right_hand_side, segment.start, session_.state()),
          "ERKStepReInit");
    check(ERKStepSetMaxStep(memory_.get(), segment.max_step), "ERKStepSetMaxStep");
    time_ = segment.start;
  }

  /// Ends a step at `time` [s], because interpolation has a lower order than the method.
  void advance(double time) override {
    check(ERKStepSetStopTime(memory_.get(), time), "ERKStepSetStopTime");
    const int flag = ERKStepEvolve(memory_.get(), time, session_.state(), &time_, ARK_NORMAL);
    if (flag < 0) { ERKStepGetCurrentTime(memory_.get(), &time_); }
    check(flag, "ERKStepEvolve");
    ARKodeButcherTable used = nullptr;
    check(ERKStepGetCurrentButcherTable(memory_.get(), &used), "ERKStepGetCurrentButcherTable");
    sundials::refuse_stale_stage(used, session_.solver());
  }

  [[nodiscard]] const double* state() const override { return session_.state_values(); }

  [[nodiscard]] long segment_steps() const override {
    long steps = 0;
    check(ERKStepGetNumSteps(memory_.get(), &steps), "ERKStepGetNumSteps");
    return steps;
  }

 private:
  void check(int flag, const char* function) const {
    session_.check(flag, function, ERKStepGetReturnFlagName, time_);
  }

  Session session_;
  std::unique_ptr<void, sundials::Deleter<ERKStepFree>> memory_;
  double time_ = 0.0;
};

class Implicit final : public Integrator {
 public:
  Implicit(const char* name, const Problem& problem, const Tolerance& tolerance)
      : session_(name, problem, tolerance),
        memory_(ARKStepCreate(nullptr, Session::right_hand_side, 0.0, session_.state(),
                              session_.context())) {
    session_.check_made(memory_.get(), "ARKStepCreate");
    void* const memory = memory_.get();
    check(ARKStepSetErrHandlerFn(memory, Session::complain, &session_), "ARKStepSetErrHandlerFn");
    check(ARKStepSetUserData(memory, &session_), "ARKStepSetUserData");
    const sundials::Table table = sundials::implicit_table(ARKODE_ESDIRK547L2SA_7_4_5);
    check(ARKStepSetTables(memory, table->q, table->p, table.get(), nullptr), "ARKStepSetTables");
    check(ARKStepSVtolerances(memory, tolerance.relative, session_.absolute_tolerance()),
          "ARKStepSVtolerances");
    check(ARKStepSetMaxNumSteps(memory, step_limit), "ARKStepSetMaxNumSteps");
    session_.use_sparse_jacobian();
    check(ARKStepSetLinearSolver(memory, session_.linear_solver(), session_.matrix()),
          "ARKStepSetLinearSolver");
    check(ARKStepSetJacFn(memory, Session::jacobian), "ARKStepSetJacFn");
    // By default the convergence rate of one step size is reused for the next. On linear problems
    // it is so small that a wrong first iterate is accepted.
    check(ARKStepSetNonlinCRDown(memory, 1.0), "ARKStepSetNonlinCRDown");
  }

  [[nodiscard]] Session& session() { return session_; }

  void begin(const Segment& segment) override {
    check(ARKStepReInit(memory_.get(), nullptr, Session::right_hand_side, segment.start,
                        session_.state()),
          "ARKStepReInit");
    check(ARKStepSetMaxStep(memory_.get(), segment.max_step), "ARKStepSetMaxStep");
    time_ = segment.start;
  }

  void advance(double time) override {
    check(ARKStepSetStopTime(memory_.get(), time), "ARKStepSetStopTime");
    const int flag = ARKStepEvolve(memory_.get(), time, session_.state(), &time_, ARK_NORMAL);
    if (flag < 0) { ARKStepGetCurrentTime(memory_.get(), &time_); }
    check(flag, "ARKStepEvolve");
    ARKodeButcherTable used = nullptr;
    ARKodeButcherTable unused_explicit = nullptr;
    check(ARKStepGetCurrentButcherTables(memory_.get(), &used, &unused_explicit),
          "ARKStepGetCurrentButcherTables");
    sundials::refuse_stale_stage(used, session_.solver());
  }

  [[nodiscard]] const double* state() const override { return session_.state_values(); }

  [[nodiscard]] long segment_steps() const override {
    long steps = 0;
    check(ARKStepGetNumSteps(memory_.get(), &steps), "ARKStepGetNumSteps");
    return steps;
  }

 private:
  void check(int flag, const char* function) const {
    session_.check(flag, function, ARKStepGetReturnFlagName, time_);
  }

  Session session_;
  std::unique_ptr<void, sundials::Deleter<ARKStepFree>> memory_;
  double time_ = 0.0;
};

template <class Method>
Trace solve(const char* name, Method&& integrator, const std::vector<double>& times,
            const Tolerance& tolerance) {
  return integrate({name, sundials::version()}, integrator.session().system(), times, tolerance,
                   integrator);
}

}  // namespace

Trace solve_arkode_explicit(const Problem& problem, const std::vector<double>& times,
                            const Tolerance& tolerance) {
  constexpr const char* name = "arkode-fehlberg-7-8";
  return solve(name, Explicit(name, ARKODE_FEHLBERG_13_7_8, problem, tolerance), times, tolerance);
}

Trace solve_arkode_dormand_prince(const Problem& problem, const std::vector<double>& times,
                                  const Tolerance& tolerance) {
  constexpr const char* name = "arkode-dormand-prince-5-4";
  return solve(name, Explicit(name, ARKODE_DORMAND_PRINCE_7_4_5, problem, tolerance), times,
               tolerance);
}

Trace solve_arkode_esdirk(const Problem& problem, const std::vector<double>& times,
                          const Tolerance& tolerance) {
  constexpr const char* name = "arkode-esdirk-5-4";
  return solve(name, Implicit(name, problem, tolerance), times, tolerance);
}

}  // namespace palpate::reference
