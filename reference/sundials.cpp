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
#include <cstring>
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

Session::Session(std::string solver, const char* prefix, char* (*flag_name)(long),
                 const Eigen::VectorXd& start, const Eigen::VectorXd& absolute, Rate rate)
    : solver_(std::move(solver)),
      prefix_(prefix),
      flag_name_(flag_name),
      rate_(std::move(rate)),
      context_(make_context()),
      state_(N_VNew_Serial(start.size(), context())) {
  check_made(state_.get(), "N_VNew_Serial");
  absolute_.reset(N_VClone(vector()));
  check_made(absolute_.get(), "N_VClone");
  std::ranges::copy(start, N_VGetArrayPointer(vector()));
  std::ranges::copy(absolute, N_VGetArrayPointer(absolute_tolerance()));
}

void Session::use_sparse_jacobian(const FirstOrderSystem& system) {
  jacobian_of_ = &system;
  const SparseJacobian jacobian = first_order_jacobian(system, values());
  matrix_.reset(
      SUNSparseMatrix(jacobian.rows(), jacobian.cols(), jacobian.nonZeros(), CSC_MAT, context()));
  check_made(matrix_.get(), "SUNSparseMatrix");
  linear_solver_.reset(SUNLinSol_KLU(vector(), matrix(), context()));
  check_made(linear_solver_.get(), "SUNLinSol_KLU");
  constexpr int minimum_degree = 0;  // AMD; faster than COLAMD on lattices
  if (SUNLinSol_KLUSetOrdering(linear_solver(), minimum_degree) != 0) {
    fail(solver_, "SUNLinSol_KLUSetOrdering", "an error", 0.0, "");
  }
}

void Session::check(int flag, const std::string& function) const {
  if (flag >= 0) { return; }
  const std::unique_ptr<char, Deleter<std::free>> name(flag_name_(flag));
  const std::string why =
      cause_.empty() || complaint_.empty() ? cause_ + complaint_ : cause_ + "; " + complaint_;
  fail(solver_, prefix_ + function, name ? name.get() : std::to_string(flag), time_, why);
}

void Session::check_made(const void* handle, const char* function) const {
  if (handle == nullptr) { fail(solver_, function, "NULL", 0.0, complaint_); }
}

int Session::right_hand_side(realtype t, N_Vector y, N_Vector dy, void* session) {
  auto& self = *static_cast<Session*>(session);
  return self.guarded([&] {
    const bool finite = self.rate_(t, N_VGetArrayPointer(y), N_VGetArrayPointer(dy));
    if (!finite) { self.cause_ = "the right-hand side is not finite" + at(t); }
    return finite;
  });
}

int Session::jacobian(realtype, N_Vector y, N_Vector, SUNMatrix matrix, void* session, N_Vector,
                      N_Vector, N_Vector) {
  auto& self = *static_cast<Session*>(session);
  return self.guarded([&] {
    const SparseJacobian jacobian = first_order_jacobian(*self.jacobian_of_, N_VGetArrayPointer(y));
    if (jacobian.nonZeros() != SUNSparseMatrix_NNZ(matrix)) {
      throw SolverError("the pattern of the problem's Jacobian has changed");
    }
    // The library also clears the indices before this call, so the pattern is written every time.
    std::copy_n(jacobian.outerIndexPtr(), jacobian.cols() + 1,
                SUNSparseMatrix_IndexPointers(matrix));
    std::copy_n(jacobian.innerIndexPtr(), jacobian.nonZeros(), SUNSparseMatrix_IndexValues(matrix));
    std::copy_n(jacobian.valuePtr(), jacobian.nonZeros(), SUNSparseMatrix_Data(matrix));
    return true;
  });
}

void Session::complain(int code, const char*, const char* function, char* message, void* session) {
  if (code >= 0) { return; }  // a warning; results are checked separately
  static_cast<Session*>(session)->complaint_ = std::string(function) + ": " + message;
}

Cvode::Cvode(std::string solver, int method, const Eigen::VectorXd& start, double relative,
             const Eigen::VectorXd& absolute, Rate rate, const FirstOrderSystem* system)
    : Session(std::move(solver), "CVode", CVodeGetReturnFlagName, start, absolute, std::move(rate)),
      memory_(CVodeCreate(method, context())) {
  void* const memory = memory_.get();
  check_made(memory, "CVodeCreate");
  check(CVodeSetErrHandlerFn(memory, complain, this), "SetErrHandlerFn");
  check(CVodeInit(memory, right_hand_side, 0.0, vector()), "Init");
  check(CVodeSetUserData(memory, this), "SetUserData");
  check(CVodeSVtolerances(memory, relative, absolute_tolerance()), "SVtolerances");
  check(CVodeSetMaxNumSteps(memory, step_limit), "SetMaxNumSteps");
  if (method == CV_BDF) {
    use_sparse_jacobian(*system);
    check(CVodeSetLinearSolver(memory, linear_solver(), matrix()), "SetLinearSolver");
    check(CVodeSetJacFn(memory, jacobian), "SetJacFn");
  } else {
    fixed_point_.reset(SUNNonlinSol_FixedPoint(vector(), 0, context()));
    check_made(fixed_point_.get(), "SUNNonlinSol_FixedPoint");
    check(CVodeSetNonlinearSolver(memory, fixed_point_.get()), "SetNonlinearSolver");
  }
}

void Cvode::restart(double start, double stop, double longest_step) {
  time_ = start;
  void* const memory = memory_.get();
  check(CVodeReInit(memory, start, vector()), "ReInit");
  check(CVodeSetMaxStep(memory, longest_step), "SetMaxStep");
  check(CVodeSetStopTime(memory, stop), "SetStopTime");
  // Without a minimum step, a failing right-hand side leads to millions of steps of length zero.
  check(CVodeSetMinStep(memory, 1e-14 * stop), "SetMinStep");
}

void Cvode::restart(double start, double stop, double longest_step, const Eigen::VectorXd& y) {
  std::ranges::copy(y, N_VGetArrayPointer(vector()));
  restart(start, stop, longest_step);
}

bool Cvode::evolve(double goal) {
  const int flag = CVode(memory_.get(), goal, vector(), &time_, CV_NORMAL);
  if (flag < 0) { CVodeGetCurrentTime(memory_.get(), &time_); }
  check(flag, "");
  return flag == CV_ROOT_RETURN;
}

long Cvode::steps() const {
  long steps = 0;
  check(CVodeGetNumSteps(memory_.get(), &steps), "GetNumSteps");
  return steps;
}

void Cvode::set_falling_roots(std::size_t count, Roots roots) {
  root_count_ = count;
  roots_ = std::move(roots);
  check(CVodeRootInit(memory_.get(), static_cast<int>(count), count > 0 ? root_values : nullptr),
        "RootInit");
  if (count == 0) { return; }
  std::vector<int> falling(count, -1);
  check(CVodeSetRootDirection(memory_.get(), falling.data()), "SetRootDirection");
  check(CVodeSetNoInactiveRootWarn(memory_.get()), "SetNoInactiveRootWarn");
}

std::vector<std::size_t> Cvode::found_roots() const {
  std::vector<int> flags(root_count_, 0);
  check(CVodeGetRootInfo(memory_.get(), flags.data()), "GetRootInfo");
  std::vector<std::size_t> found;
  for (std::size_t n = 0; n < root_count_; ++n) {
    if (flags[n] != 0) { found.push_back(n); }
  }
  return found;
}

int Cvode::root_values(realtype t, N_Vector y, realtype* values, void* session) {
  auto& self = *static_cast<Cvode*>(static_cast<Session*>(session));
  return self.guarded([&] {
    self.roots_(t, N_VGetArrayPointer(y), values);
    return true;
  });
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

sundials::Session::Rate rate_of(FirstOrderSystem& system) {
  return [&system](double t, const double* y, double* dy) { return system.derivative(t, y, dy); };
}

class Multistep final : public SystemIntegrator {
 public:
  Multistep(const char* name, int method, const Problem& problem, const Tolerance& tolerance)
      : SystemIntegrator(problem),
        cvode_(name, method, system_.initial_state(), tolerance.relative,
               tolerance.relative * system_.scales(tolerance), rate_of(system_), &system_) {}

  void begin(const Segment& segment) override {
    system_.set_gate(segment.gate);
    cvode_.restart(segment.start, segment.end, segment.max_step);
  }
  /// Advances with interpolation between steps, which has the accuracy of the steps. Steps end
  /// exactly only at breaks.
  void advance(double time) override { cvode_.evolve(time); }
  [[nodiscard]] const double* state() const override { return cvode_.values(); }
  [[nodiscard]] long segment_steps() const override { return cvode_.steps(); }

 private:
  sundials::Cvode cvode_;
};

/// Explicit method of ERKStep, or the implicit one of ARKStep.
class RungeKutta final : public SystemIntegrator, private sundials::Session {
 public:
  RungeKutta(const char* name, std::optional<ARKODE_ERKTableID> explicit_id, const Problem& problem,
             const Tolerance& tolerance)
      : SystemIntegrator(problem),
        Session(name, explicit_id ? "ERKStep" : "ARKStep", ERKStepGetReturnFlagName,
                system_.initial_state(), tolerance.relative * system_.scales(tolerance),
                rate_of(system_)),
        explicit_(explicit_id.has_value()),
        memory_(
            explicit_ ? ERKStepCreate(right_hand_side, 0.0, vector(), context())
                      : ARKStepCreate(nullptr, right_hand_side, 0.0, vector(), context()),
            explicit_ ? +[](void* memory) { ERKStepFree(&memory); }
                      : +[](void* memory) { ARKStepFree(&memory); }) {
    check_made(memory_.get(), "Create");
    Session* const session = this;
    call("SetErrHandlerFn", ERKStepSetErrHandlerFn, ARKStepSetErrHandlerFn, complain, session);
    call("SetUserData", ERKStepSetUserData, ARKStepSetUserData, session);
    call("SVtolerances", ERKStepSVtolerances, ARKStepSVtolerances, tolerance.relative,
         absolute_tolerance());
    call("SetMaxNumSteps", ERKStepSetMaxNumSteps, ARKStepSetMaxNumSteps, step_limit);
    void* const memory = memory_.get();
    if (explicit_) {
      const sundials::Table table = sundials::explicit_table(*explicit_id);
      check(ERKStepSetTable(memory, table.get()), "SetTable");
      return;
    }
    const sundials::Table table = sundials::implicit_table(ARKODE_ESDIRK547L2SA_7_4_5);
    check(ARKStepSetTables(memory, table->q, table->p, table.get(), nullptr), "SetTables");
    use_sparse_jacobian(system_);
    check(ARKStepSetLinearSolver(memory, linear_solver(), matrix()), "SetLinearSolver");
    check(ARKStepSetJacFn(memory, jacobian), "SetJacFn");
    // By default the convergence rate of one step size is reused for the next. On linear problems
    // it is so small that a wrong first iterate is accepted.
    check(ARKStepSetNonlinCRDown(memory, 1.0), "SetNonlinCRDown");
  }

  void begin(const Segment& segment) override {
    system_.set_gate(segment.gate);
    time_ = segment.start;
    check(explicit_ ? ERKStepReInit(memory_.get(), right_hand_side, time_, vector())
                    : ARKStepReInit(memory_.get(), nullptr, right_hand_side, time_, vector()),
          "ReInit");
    call("SetMaxStep", ERKStepSetMaxStep, ARKStepSetMaxStep, segment.max_step);
  }

  /// Ends a step at `time` [s], because interpolation has a lower order than the method.
  void advance(double time) override {
    call("SetStopTime", ERKStepSetStopTime, ARKStepSetStopTime, time);
    void* const memory = memory_.get();
    const auto evolve = explicit_ ? ERKStepEvolve : ARKStepEvolve;
    const int flag = evolve(memory, time, vector(), &time_, ARK_NORMAL);
    if (flag < 0) { (explicit_ ? ERKStepGetCurrentTime : ARKStepGetCurrentTime)(memory, &time_); }
    check(flag, "Evolve");
    ARKodeButcherTable used = nullptr;
    ARKodeButcherTable unused = nullptr;
    check(explicit_ ? ERKStepGetCurrentButcherTable(memory, &used)
                    : ARKStepGetCurrentButcherTables(memory, &used, &unused),
          "GetCurrentButcherTable");
    sundials::refuse_stale_stage(used, solver_);
  }

  [[nodiscard]] const double* state() const override { return values(); }

  [[nodiscard]] long segment_steps() const override {
    long steps = 0;
    call("GetNumSteps", ERKStepGetNumSteps, ARKStepGetNumSteps, &steps);
    return steps;
  }

 private:
  /// Calls the function of the library in use.
  template <class... Arguments>
  void call(const char* name, int (*erkstep)(void*, Arguments...),
            int (*arkstep)(void*, Arguments...),
            std::type_identity_t<Arguments>... arguments) const {
    check((explicit_ ? erkstep : arkstep)(memory_.get(), arguments...), name);
  }

  bool explicit_;
  std::unique_ptr<void, void (*)(void*)> memory_;  // freed before what it points to
};

template <class Method, class Kind>
Trace solve(const char* name, Kind kind, const Problem& problem, const std::vector<double>& times,
            const Tolerance& tolerance) {
  Method integrator(name, kind, problem, tolerance);
  return integrate({name, sundials::version()}, problem, times, tolerance, integrator);
}

}  // namespace

Trace solve_cvode_adams(const Problem& problem, const std::vector<double>& times,
                        const Tolerance& tolerance) {
  return solve<Multistep>("cvode-adams", CV_ADAMS, problem, times, tolerance);
}

Trace solve_cvode_bdf(const Problem& problem, const std::vector<double>& times,
                      const Tolerance& tolerance) {
  return solve<Multistep>("cvode-bdf", CV_BDF, problem, times, tolerance);
}

Trace solve_arkode_explicit(const Problem& problem, const std::vector<double>& times,
                            const Tolerance& tolerance) {
  return solve<RungeKutta>("arkode-fehlberg-7-8", ARKODE_FEHLBERG_13_7_8, problem, times,
                           tolerance);
}

Trace solve_arkode_dormand_prince(const Problem& problem, const std::vector<double>& times,
                                  const Tolerance& tolerance) {
  return solve<RungeKutta>("arkode-dormand-prince-5-4", ARKODE_DORMAND_PRINCE_7_4_5, problem, times,
                           tolerance);
}

Trace solve_arkode_esdirk(const Problem& problem, const std::vector<double>& times,
                          const Tolerance& tolerance) {
  return solve<RungeKutta>("arkode-esdirk-5-4", std::nullopt, problem, times, tolerance);
}

}  // namespace palpate::reference
