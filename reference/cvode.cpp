// SPDX-License-Identifier: MIT
#include "reference/cvode.hpp"

#include <cvode/cvode.h>
#include <cvode/cvode_ls.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include "reference/sundials.hpp"

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
    // Without it, a right-hand side that fails is approached by ten million steps of no length.
    check(CVodeSetMinStep(memory_.get(), 1e-14 * segment.end), "CVodeSetMinStep");
    time_ = segment.start;
  }

  /// Interpolated between steps: as accurate as the steps, which end exactly at breaks only.
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

Solution solve(const char* name, int multistep, const Problem& problem,
               const std::vector<double>& times, const Tolerance& tolerance) {
  Cvode integrator(name, multistep, problem, tolerance);
  return march({name, sundials::version()}, integrator.session().system(), times, tolerance,
               integrator);
}

}  // namespace

Solution solve_cvode_adams(const Problem& problem, const std::vector<double>& times,
                           const Tolerance& tolerance) {
  return solve("cvode-adams", CV_ADAMS, problem, times, tolerance);
}

Solution solve_cvode_bdf(const Problem& problem, const std::vector<double>& times,
                         const Tolerance& tolerance) {
  return solve("cvode-bdf", CV_BDF, problem, times, tolerance);
}

}  // namespace palpate::reference
