// SPDX-License-Identifier: MIT
// Reason why references restart at breaks and limit their steps: a solver without both steps over a
// short load, reports success and has an error of 100 %.

#include "reference/sundials.hpp"

#include <arkode/arkode_butcher_dirk.h>
#include <arkode/arkode_butcher_erk.h>
#include <arkode/arkode_erkstep.h>
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include "reference/solver_cross_check.hpp"
#include "reference/solvers.hpp"
#include "tests/check.hpp"
#include "tests/reference/sample_problems.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using namespace palpate::reference;
using Eigen::Index;
using Eigen::VectorXd;

namespace guarded = palpate::reference::sundials;  // a library namespace has that name too

/// Load of 10 ms that starts after half a second of rest.
NetworkProblem late_push() {
  Load load = sample::pulse(0.5);
  load.start = 0.500;
  load.end = 0.510;
  return NetworkProblem(sample::block({.nodes = 3}), {load});
}

int network_rate(double t, N_Vector y, N_Vector dy, void* problem) {
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

/// CVODE as in its examples: BDF, dense difference Jacobian, no stop times, no step limit.
Naive naive_bdf(NetworkProblem problem, double end, double relative) {
  const Index n = problem.dof();
  SUNContext raw = nullptr;
  SUNContext_Create(nullptr, &raw);
  const guarded::Context context(raw);
  const guarded::Vector y(N_VNew_Serial(2 * n, raw));
  Eigen::Map<VectorXd> state(N_VGetArrayPointer(y.get()), 2 * n);
  state << problem.initial_position(), problem.initial_velocity();
  const guarded::Vector absolute(N_VClone(y.get()));
  Eigen::Map<VectorXd> tolerance(N_VGetArrayPointer(absolute.get()), 2 * n);
  tolerance.head(n).setConstant(relative * 1e-3);
  tolerance.tail(n).setConstant(relative * 1e-1);
  const std::unique_ptr<void, guarded::Deleter<CVodeFree>> memory(CVodeCreate(CV_BDF, raw));
  CVodeInit(memory.get(), network_rate, 0.0, y.get());
  CVodeSetUserData(memory.get(), &problem);
  CVodeSVtolerances(memory.get(), relative, absolute.get());
  const guarded::Matrix matrix(SUNDenseMatrix(2 * n, 2 * n, raw));
  const guarded::LinearSolver solver(SUNLinSol_Dense(y.get(), matrix.get(), raw));
  CVodeSetLinearSolver(memory.get(), solver.get(), matrix.get());
  double t = 0.0;
  Naive result{.flag = CVode(memory.get(), end, y.get(), &t, CV_NORMAL)};
  CVodeGetNumSteps(memory.get(), &result.steps);
  result.position = state.head(n);
  return result;
}

TEST("naive CVODE-BDF steps over a push of 10 ms, reports success and is 100 % wrong") {
  const NetworkProblem problem = late_push();
  const Naive naive = naive_bdf(problem, 0.512, 1e-4);
  const Trace truth =
      solver_named("arkode-fehlberg-7-8").solve(problem, {0.0, 0.512}, {.relative = 1e-11});
  const double error = (naive.position - truth.position.col(1)).cwiseAbs().maxCoeff() /
                       peak_displacement(truth.position);
  CHECK(naive.flag == CV_SUCCESS);
  CHECK(naive.steps < 50);
  CHECK_NEAR(error, 1.0, 0.01);
}

TEST("no solver of ours steps over the push, at the same tolerance") {
  const NetworkProblem problem = late_push();
  const auto times = sample::instants(0.512, 1);
  const Trace truth =
      solver_named("arkode-fehlberg-7-8").solve(problem, times, {.relative = 1e-11});
  const double peak = peak_displacement(truth.position);
  for (const char* name : {"cvode-bdf", "cvode-adams", "arkode-fehlberg-7-8", "arkode-esdirk-5-4",
                           "gsl-rk8pd", "gsl-msbdf", "long-double-fehlberg-7-8"}) {
    const Trace ours = solver_named(name).solve(problem, times, {.relative = 1e-4});
    const double error = trajectory_error(ours.position, truth.position, peak);
    CHECK_NEAR(error, 0.0, 0.02);  // tolerance 1e-4, grown over some hundred steps of low order
  }
}

// SUNDIALS 6.4 uses a stage at the end of the step as the new solution (runge_kutta_table.hpp).
// These tests show the effect on stock tables; our tables are not affected.

using guarded::Table;

const Oscillator driven{.viscosity = 0.3, .drive_amplitude = 0.7, .drive_frequency = 1.7};

int right_hand_side(double t, N_Vector y, N_Vector dy, void* oscillator) {
  const auto& o = *static_cast<const Oscillator*>(oscillator);
  const double* x = N_VGetArrayPointer(y);
  double* dx = N_VGetArrayPointer(dy);
  dx[0] = x[1];
  dx[1] = (o.drive_amplitude * std::cos(o.drive_frequency * t) - o.stiffness * x[0] -
           o.viscosity * x[1]) /
          o.mass;
  return 0;
}

/// ERKStep without our wrapper on an oscillator.
struct ErkStep {
  explicit ErkStep(const Oscillator& of) : oscillator(of) {
    SUNContext raw = nullptr;
    CHECK(SUNContext_Create(nullptr, &raw) == 0);
    context.reset(raw);
    y.reset(N_VNew_Serial(2, raw));
    N_VGetArrayPointer(y.get())[0] = oscillator.displacement;
    N_VGetArrayPointer(y.get())[1] = oscillator.velocity;
    memory.reset(ERKStepCreate(right_hand_side, 0.0, y.get(), raw));
    CHECK(ERKStepSetUserData(memory.get(), &oscillator) == 0);
  }
  ErkStep(const ErkStep&) = delete;  // the library keeps its address
  ErkStep& operator=(const ErkStep&) = delete;

  void advance(double end, int steps) const {
    CHECK(ERKStepSetFixedStep(memory.get(), end / steps) == 0);
    CHECK(ERKStepSetMaxNumSteps(memory.get(), 10 * steps) == 0);
    CHECK(ERKStepSetStopTime(memory.get(), end) == 0);
    double t = 0.0;
    CHECK(ERKStepEvolve(memory.get(), end, y.get(), &t, ARK_NORMAL) >= 0);
  }
  [[nodiscard]] double position() const { return N_VGetArrayPointer(y.get())[0]; }
  [[nodiscard]] double evaluations_per_step() const {
    long taken = 0, evaluations = 0;
    ERKStepGetNumSteps(memory.get(), &taken);
    ERKStepGetNumRhsEvals(memory.get(), &evaluations);
    return static_cast<double>(evaluations) / static_cast<double>(taken);
  }

  Oscillator oscillator;
  guarded::Context context;
  guarded::Vector y;
  std::unique_ptr<void, guarded::Deleter<ERKStepFree>> memory;
};

struct FixedSteps {
  double position = 0.0;
  double evaluations_per_step = 0.0;
};

FixedSteps run(ARKodeButcherTable table, const Oscillator& o, double end, int steps) {
  const ErkStep erk(o);
  CHECK(ERKStepSetTable(erk.memory.get(), table) == 0);
  erk.advance(end, steps);
  return {erk.position(), erk.evaluations_per_step()};
}

double observed_order(ARKodeButcherTable table, int steps) {
  const double end = 8.0;
  const double exact = sample::exact(driven, end).position;
  const double coarse = std::abs(run(table, driven, end, steps).position - exact);
  const double fine = std::abs(run(table, driven, end, 2 * steps).position - exact);
  return std::log2(coarse / fine);
}

Table stock(ARKODE_ERKTableID id) { return Table(ARKodeButcherTable_LoadERK(id)); }

TEST("only tables with a last stage at the end that is not the solution are unsafe and changed") {
  for (const auto id : {ARKODE_HEUN_EULER_2_1_2, ARKODE_VERNER_8_5_6, ARKODE_FEHLBERG_13_7_8}) {
    CHECK(!guarded::reuses_no_stale_stage(*stock(id)));
    CHECK(guarded::reuses_no_stale_stage(*guarded::explicit_table(id)));
  }
  for (const auto id : {ARKODE_BOGACKI_SHAMPINE_4_2_3, ARKODE_ZONNEVELD_5_3_4,
                        ARKODE_CASH_KARP_6_4_5, ARKODE_DORMAND_PRINCE_7_4_5}) {
    CHECK(guarded::reuses_no_stale_stage(*stock(id)));
    CHECK(guarded::explicit_table(id)->stages == stock(id)->stages);
  }
  CHECK(guarded::reuses_no_stale_stage(*guarded::implicit_table(ARKODE_ESDIRK547L2SA_7_4_5)));
}

TEST("ERKStep of order 2 takes a table that it spoils and a reference refuses; 3 to 5 are sound") {
  for (const int order : {2, 3, 4, 5}) {
    const ErkStep erk(driven);
    CHECK(ERKStepSetOrder(erk.memory.get(), order) == 0);
    erk.advance(1.0, 50);
    ARKodeButcherTable chosen = nullptr;
    CHECK(ERKStepGetCurrentButcherTable(erk.memory.get(), &chosen) == 0);
    REQUIRE(chosen != nullptr);
    CHECK(chosen->q == order);
    CHECK(guarded::reuses_no_stale_stage(*chosen) == (order != 2));
    if (order == 2) {
      CHECK_THROWS(guarded::refuse_stale_stage(chosen, "erk"), "erk: SUNDIALS chose");
      CHECK(erk.evaluations_per_step() < 1.1);  // Heun's method has two
    } else {
      guarded::refuse_stale_stage(chosen, "erk");
    }
  }
  CHECK_THROWS(guarded::refuse_stale_stage(nullptr, "erk"), "erk: SUNDIALS chose");
}

TEST("an added stage changes neither the order conditions nor the embedding") {
  int order = 0, embedded = 0;
  const Table table = guarded::explicit_table(ARKODE_VERNER_8_5_6);
  CHECK(ARKodeButcherTable_CheckOrder(table.get(), &order, &embedded, nullptr) >= 0);
  CHECK(order == 6);
  CHECK(embedded == 5);
}

TEST("stock Heun-Euler evaluates once a step instead of twice; ours never reuses") {
  const Table heun = stock(ARKODE_HEUN_EULER_2_1_2);
  CHECK_NEAR(run(heun.get(), driven, 8.0, 100).evaluations_per_step, 1.0, 0.05);
  const Table ours = guarded::explicit_table(ARKODE_HEUN_EULER_2_1_2);
  CHECK_NEAR(run(ours.get(), driven, 8.0, 100).evaluations_per_step, 3.0, 0.05);
}

TEST("stock Heun-Euler is unstable where Heun's method is stable") {
  // Overdamped: rates -0.101 and -9.9; h = 0.18 is h |rate| = 1.78 < 2, the limit of order 2.
  const Oscillator stiff{.viscosity = 10.0};
  const Table heun = stock(ARKODE_HEUN_EULER_2_1_2);
  const Table ours = guarded::explicit_table(ARKODE_HEUN_EULER_2_1_2);
  CHECK(std::abs(run(ours.get(), stiff, 90.0, 500).position) < 1e-3);
  CHECK(!(std::abs(run(heun.get(), stiff, 90.0, 500).position) < 1e3));
}

TEST("stock Verner 8-5-6 has order 3, with an added stage 6") {
  CHECK_NEAR(observed_order(stock(ARKODE_VERNER_8_5_6).get(), 40), 3.0, 0.3);
  CHECK(observed_order(guarded::explicit_table(ARKODE_VERNER_8_5_6).get(), 40) > 5.7);
}

TEST("stock Fehlberg 13-7-8 saves an evaluation and loses its order, with an added stage it is 8") {
  const Table fehlberg = stock(ARKODE_FEHLBERG_13_7_8);
  const Table ours = guarded::explicit_table(ARKODE_FEHLBERG_13_7_8);
  CHECK_NEAR(run(fehlberg.get(), driven, 8.0, 400).evaluations_per_step, 12.0, 0.05);
  CHECK_NEAR(run(ours.get(), driven, 8.0, 400).evaluations_per_step, 14.0, 0.05);
  CHECK(observed_order(ours.get(), 10) > 7.8);
  const double exact = sample::exact(driven, 8.0).position;
  const double stale = std::abs(run(fehlberg.get(), driven, 8.0, 20).position - exact);
  const double sound = std::abs(run(ours.get(), driven, 8.0, 20).position - exact);
  CHECK(sound < 0.1 * stale);
}

}  // namespace PALPATE_FILE
