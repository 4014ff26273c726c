// SPDX-License-Identifier: MIT
// Why references restart at breaks and limit their steps: a solver that does neither steps over a
// short load, reports success and is 100 % wrong.
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include "reference/solvers.hpp"
#include "reference/trajectory_error.hpp"
#include "tests/check.hpp"
#include "tests/reference/sample_problems.hpp"

using Eigen::Index;
using Eigen::VectorXd;
using palpate::Load;
using palpate::NetworkProblem;
using palpate::reference::peak_displacement;
using palpate::reference::Solution;
using palpate::reference::solver_named;
using palpate::reference::trajectory_error;

namespace {

/// 10 ms of push that begins after half a second of rest.
NetworkProblem late_push() {
  Load load = sample::pulse(0.5);
  load.start = 0.500;
  load.end = 0.510;
  return NetworkProblem(sample::block({.nodes = 3}), {load});
}

int right_hand_side(double t, N_Vector y, N_Vector dy, void* problem) {
  const auto& p = *static_cast<const NetworkProblem*>(problem);
  const Index n = p.dof();
  const Eigen::Map<const VectorXd> state(N_VGetArrayPointer(y), 2 * n);
  Eigen::Map<VectorXd> rate(N_VGetArrayPointer(dy), 2 * n);
  VectorXd force(n);
  p.force(t, t, state.head(n), state.tail(n), force);
  rate << state.tail(n), force.cwiseQuotient(p.mass());
  return 0;
}

struct Naive {
  int flag = 0;
  long steps = 0;
  VectorXd position{};
};

/// CVODE as its examples use it: BDF, dense Jacobian by differences, no stops, no step limit.
Naive naive_bdf(NetworkProblem problem, double end, double relative) {
  const Index n = problem.dof();
  SUNContext context = nullptr;
  SUNContext_Create(nullptr, &context);
  N_Vector y = N_VNew_Serial(2 * n, context);
  Eigen::Map<VectorXd>(N_VGetArrayPointer(y), 2 * n) << problem.initial_position(),
      problem.initial_velocity();
  N_Vector absolute = N_VClone(y);
  Eigen::Map<VectorXd> tolerance(N_VGetArrayPointer(absolute), 2 * n);
  tolerance.head(n).setConstant(relative * 1e-3);
  tolerance.tail(n).setConstant(relative * 1e-1);
  void* memory = CVodeCreate(CV_BDF, context);
  CVodeInit(memory, right_hand_side, 0.0, y);
  CVodeSetUserData(memory, &problem);
  CVodeSVtolerances(memory, relative, absolute);
  SUNMatrix matrix = SUNDenseMatrix(2 * n, 2 * n, context);
  SUNLinearSolver solver = SUNLinSol_Dense(y, matrix, context);
  CVodeSetLinearSolver(memory, solver, matrix);
  double t = 0.0;
  Naive result{.flag = CVode(memory, end, y, &t, CV_NORMAL)};
  CVodeGetNumSteps(memory, &result.steps);
  result.position = Eigen::Map<VectorXd>(N_VGetArrayPointer(y), n);
  CVodeFree(&memory);
  SUNLinSolFree(solver);
  SUNMatDestroy(matrix);
  N_VDestroy(absolute);
  N_VDestroy(y);
  SUNContext_Free(&context);
  return result;
}

}  // namespace

TEST("naive CVODE-BDF steps over a push of 10 ms, reports success and is 100 % wrong") {
  const NetworkProblem problem = late_push();
  const Naive naive = naive_bdf(problem, 0.512, 1e-4);
  const Solution truth =
      solver_named("arkode-fehlberg-7-8").solve(problem, {0.0, 0.512}, {.relative = 1e-11});
  const double error = (naive.position - truth.position.col(1)).cwiseAbs().maxCoeff() /
                       peak_displacement(truth.position);
  std::printf("  %ld steps, flag %d, error %.1f %%\n", naive.steps, naive.flag, 100.0 * error);
  CHECK(naive.flag == CV_SUCCESS);
  CHECK(naive.steps < 50);
  CHECK_NEAR(error, 1.0, 0.01);
}

TEST("no solver of ours steps over the push, at the same tolerance") {
  const NetworkProblem problem = late_push();
  const auto times = sample::instants(0.512, 1);
  const Solution truth =
      solver_named("arkode-fehlberg-7-8").solve(problem, times, {.relative = 1e-11});
  const double peak = peak_displacement(truth.position);
  for (const char* name : {"cvode-bdf", "cvode-adams", "arkode-fehlberg-7-8", "arkode-esdirk-5-4",
                           "gsl-rk8pd", "gsl-msbdf", "long-double-fehlberg-7-8"}) {
    const Solution ours = solver_named(name).solve(problem, times, {.relative = 1e-4});
    const double error = trajectory_error(ours.position, truth.position, peak);
    std::printf("  %-26s %5ld steps, error %.1e\n", name, ours.steps, error);
    CHECK_NEAR(error, 0.0, 0.02);  // tolerance 1e-4, grown over some hundred steps of low order
  }
}
