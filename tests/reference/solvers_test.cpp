// SPDX-License-Identifier: MIT
// What every solver of the list must do, whatever library it comes from.
#include "reference/solvers.hpp"

#include <stdexcept>

#include "reference/trajectory_error.hpp"
#include "tests/check.hpp"
#include "tests/reference/sample_problems.hpp"

using palpate::NetworkProblem;
using palpate::Oscillator;
using palpate::OscillatorProblem;
using palpate::Problem;
using palpate::reference::all_solvers;
using palpate::reference::NamedSolver;
using palpate::reference::Solution;
using palpate::reference::SolverError;
using palpate::reference::Tolerance;

namespace {

constexpr Tolerance unit_scale{.relative = 1e-11, .position_scale = 1.0, .velocity_scale = 1.0};

/// Global error over local tolerance, measured over 25 s of motion with a margin of three: methods
/// that control the error per step let it grow with the number of steps.
double expected_error(const NamedSolver& solver) {
  if (solver.family == "modal") { return 1e-13; }
  if (solver.family == "bdf") { return 1e-7; }
  if (solver.family == "adams") { return 5e-9; }
  // Weighs errors with |y| + h |y'|, so allows some more than the others.
  if (solver.name.starts_with("odeint")) { return 3e-10; }
  return 1e-10;
}

void compare(const Oscillator& oscillator, sample::Motion (*exact)(const Oscillator&, double)) {
  const OscillatorProblem problem(oscillator);
  const auto times = sample::instants(25.0, 100);
  for (const NamedSolver& solver : all_solvers()) {
    const Solution solution = solver.solve(problem, times, unit_scale);
    double error = 0.0;
    for (std::size_t n = 0; n < times.size(); ++n) {
      const auto motion = exact(oscillator, times[n]);
      const auto column = static_cast<Eigen::Index>(n);
      error = std::fmax(error, std::abs(solution.position(0, column) - motion.position));
      error = std::fmax(error, std::abs(solution.velocity(0, column) - motion.velocity));
    }
    std::printf("  %-26s %.1e\n", solver.name.c_str(), error);
    CHECK_NEAR(error, 0.0, expected_error(solver));
    CHECK(solution.solver == solver.name);
    CHECK(solution.steps >= 10 || solver.family == "modal");
  }
}

class NanAfter final : public sample::Wrapped {
 public:
  NanAfter(const Problem& base, double instant) : Wrapped(base), instant_(instant) {}
  void force(double t, double gate, const Eigen::Ref<const Eigen::VectorXd>& q,
             const Eigen::Ref<const Eigen::VectorXd>& v,
             Eigen::Ref<Eigen::VectorXd> f) const override {
    Wrapped::force(t, gate, q, v, f);
    if (t > instant_) { f(0) = std::nan(""); }
  }

 private:
  double instant_;
};

class ThrowsAfter final : public sample::Wrapped {
 public:
  using Wrapped::Wrapped;
  void force(double t, double gate, const Eigen::Ref<const Eigen::VectorXd>& q,
             const Eigen::Ref<const Eigen::VectorXd>& v,
             Eigen::Ref<Eigen::VectorXd> f) const override {
    if (t > 0.5) { throw std::runtime_error("planted"); }
    Wrapped::force(t, gate, q, v, f);
  }
};

/// Solvers that call Problem::force while they step.
bool steps_the_problem(const NamedSolver& solver) {
  return solver.family != "modal" && !solver.name.starts_with("long-double");
}

}  // namespace

TEST("every solver follows the underdamped oscillator") {
  compare({.viscosity = 0.3}, sample::exact);
}

TEST("every solver follows the critically damped oscillator") {
  compare({.viscosity = 2.0, .velocity = 0.5}, sample::exact_critical);
}

TEST("every solver follows the overdamped oscillator") {
  compare({.viscosity = 5.0, .velocity = 1.0}, sample::exact);
}

TEST("every solver follows the undamped oscillator") {
  compare({.viscosity = 0.0, .velocity = -0.5}, sample::exact);
}

TEST("every solver follows the driven oscillator") {
  compare({.viscosity = 0.3, .drive_amplitude = 0.7, .drive_frequency = 1.7}, sample::exact);
}

TEST("a force that becomes NaN is an error that names solver and time, never a result or a hang") {
  const OscillatorProblem healthy(Oscillator{.viscosity = 0.3});
  for (const double instant : {-1.0, 0.5}) {
    const NanAfter problem(healthy, instant);
    for (const NamedSolver& solver : all_solvers()) {
      if (!steps_the_problem(solver)) { continue; }
      CHECK_THROWS(solver.solve(problem, {0.0, 1.0, 2.0}, unit_scale), solver.name);
      CHECK_THROWS(solver.solve(problem, {0.0, 1.0, 2.0}, unit_scale), "not finite");
    }
  }
}

TEST("an exception of the problem crosses the C libraries as a SolverError with its message") {
  const OscillatorProblem healthy(Oscillator{.viscosity = 0.3});
  const ThrowsAfter problem(healthy);
  for (const NamedSolver& solver : all_solvers()) {
    if (!steps_the_problem(solver)) { continue; }
    CHECK_THROWS(solver.solve(problem, {0.0, 1.0, 2.0}, unit_scale), "planted");
  }
}

TEST("a motion that grows beyond all numbers is an error") {
  const OscillatorProblem problem(Oscillator{.viscosity = -2000.0});
  for (const NamedSolver& solver : all_solvers()) {
    CHECK_THROWS(solver.solve(problem, {0.0, 1.0, 2.0}, unit_scale), solver.name.substr(0, 5));
  }
}

TEST("the initial state is stored unchanged and a single instant needs no step") {
  const OscillatorProblem problem(Oscillator{.velocity = 0.25});
  for (const NamedSolver& solver : all_solvers()) {
    const Solution solution = solver.solve(problem, {0.0}, unit_scale);
    CHECK_NEAR(solution.position(0, 0), 1.0, 1e-15);
    CHECK_NEAR(solution.velocity(0, 0), 0.25, 1e-15);
  }
}

TEST("where the origin lies changes nothing") {
  // Rounding 1 m away is 1e-16 m of 4e-4 m of motion, but it makes the solvers choose other steps,
  // so results differ by their own errors: 1e-9 at this tolerance.
  palpate::SpringNetwork moved = sample::block({.nodes = 3});
  moved.rest_position.colwise() += Eigen::Vector3d(1.0, -0.5, 0.25);
  const NetworkProblem here(sample::block({.nodes = 3}), {sample::pulse(0.5)});
  const NetworkProblem there(moved, {sample::pulse(0.5)});
  const auto times = sample::instants(0.03, 6);
  for (const char* name : {"arkode-fehlberg-7-8", "cvode-adams", "gsl-rk8pd"}) {
    const auto& solver = palpate::reference::solver_named(name);
    const Solution a = solver.solve(here, times, {.relative = 1e-10});
    Solution b = solver.solve(there, times, {.relative = 1e-10});
    b.position.colwise() += a.position.col(0) - b.position.col(0);
    const double peak = palpate::reference::peak_displacement(a.position);
    CHECK_NEAR(palpate::reference::trajectory_error(b.position, a.position, peak), 0.0, 1e-8);
  }
}

TEST("an unknown solver is refused with those that exist") {
  CHECK_THROWS(palpate::reference::solver_named("euler"), "cvode-adams");
}
