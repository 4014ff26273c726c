// SPDX-License-Identifier: MIT
#include "reference/arkode.hpp"

#include <arkode/arkode_arkstep.h>
#include <arkode/arkode_erkstep.h>

#include "reference/runge_kutta_table.hpp"
#include "reference/sundials.hpp"

namespace palpate::reference {

namespace {

using sundials::Session;

class Explicit final : public Integrator {
 public:
  Explicit(const char* name, ARKODE_ERKTableID id, const Problem& problem, const Tolerance& tolerance)
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

  /// Ends a step at `time`: interpolation would be of lower order than the method.
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
    // By default a rate of convergence measured with one step size is trusted with the next, and on
    // linear problems it is so good that a wrong first iterate passes: 1e-4 instead of 1e-11.
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
Solution solve(const char* name, Method&& integrator, const std::vector<double>& times,
               const Tolerance& tolerance) {
  return march({name, sundials::version()}, integrator.session().system(), times, tolerance,
               integrator);
}

}  // namespace

Solution solve_arkode_explicit(const Problem& problem, const std::vector<double>& times,
                               const Tolerance& tolerance) {
  constexpr const char* name = "arkode-fehlberg-7-8";
  return solve(name, Explicit(name, ARKODE_FEHLBERG_13_7_8, problem, tolerance), times, tolerance);
}

Solution solve_arkode_dormand_prince(const Problem& problem, const std::vector<double>& times,
                                     const Tolerance& tolerance) {
  constexpr const char* name = "arkode-dormand-prince-5-4";
  return solve(name, Explicit(name, ARKODE_DORMAND_PRINCE_7_4_5, problem, tolerance), times,
               tolerance);
}

Solution solve_arkode_esdirk(const Problem& problem, const std::vector<double>& times,
                             const Tolerance& tolerance) {
  constexpr const char* name = "arkode-esdirk-5-4";
  return solve(name, Implicit(name, problem, tolerance), times, tolerance);
}

}  // namespace palpate::reference
