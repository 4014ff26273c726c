// SPDX-License-Identifier: MIT
#include "reference/modal.hpp"

#include <algorithm>
#include <numbers>

#include "reference/arkode.hpp"
#include "reference/cvode.hpp"
#include "reference/linear_problem.hpp"
#include "reference/trajectory_error.hpp"
#include "tests/check.hpp"
#include "tests/reference/sample_problems.hpp"

using palpate::Load;
using palpate::NetworkProblem;
using palpate::Problem;
using palpate::Profile;
using palpate::reference::LinearProblem;
using palpate::reference::modal_solution;
using palpate::reference::natural_frequencies;
using palpate::reference::peak_displacement;
using palpate::reference::peak_speed;
using palpate::reference::Solution;
using palpate::reference::solve_arkode_explicit;
using palpate::reference::solve_cvode_adams;
using palpate::reference::trajectory_error;

namespace {

double distance(const Solution& a, const Solution& b) {
  return std::max(trajectory_error(a.position, b.position, peak_displacement(b.position)),
                  trajectory_error(a.velocity, b.velocity, peak_speed(b.velocity)));
}

std::vector<Load> overlapping_loads(double newton) {
  const Load half_sine = sample::pulse(newton);
  const Load step{.nodes = {3, 5}, .force = {0.0, newton, 0.0}, .start = 0.0, .end = 8e-3};
  const Load ramp{.nodes = {7},
                  .force = {newton, 0.0, newton},
                  .start = 2e-3,
                  .end = 12e-3,
                  .profile = Profile::ramp};
  const Load lasting{.nodes = {1}, .force = {0.0, 0.0, newton}, .start = 4e-3};
  return {half_sine, step, ramp, lasting};
}

}  // namespace

TEST("a fixed-free chain has its exact natural frequencies") {
  const int n = 12;
  const NetworkProblem problem(sample::chain(n, 50.0, 2e-3, false));
  const Eigen::VectorXd omega = natural_frequencies(problem);
  for (int j = 1; j <= n; ++j) {
    const double exact = 2.0 * std::sqrt(50.0 / 2e-3) *
                         std::sin((2 * j - 1) * std::numbers::pi / (2.0 * (2 * n + 1)));
    CHECK_NEAR(omega(2 * n + j - 1) / exact, 1.0, 1e-12);  // 2 n sideways motions come first
  }
  CHECK_NEAR(omega(2 * n - 1) / omega(3 * n - 1), 0.0, 1e-7);  // the root of rounding
}

TEST("a chain fixed at both ends has its exact natural frequencies") {
  const int n = 9;
  const NetworkProblem problem(sample::chain(n, 50.0, 2e-3, true));
  const Eigen::VectorXd omega = natural_frequencies(problem);
  for (int j = 1; j <= n; ++j) {
    const double exact =
        2.0 * std::sqrt(50.0 / 2e-3) * std::sin(j * std::numbers::pi / (2.0 * (n + 1)));
    CHECK_NEAR(omega(2 * n + j - 1) / exact, 1.0, 1e-12);
  }
}

TEST("modal superposition solves the linearised lattice under all shapes of load") {
  const NetworkProblem network(sample::block({.nodes = 4}), overlapping_loads(0.3),
                               {0.0, 0.0, 9.81});
  const LinearProblem linear(network);
  const auto times = sample::instants(0.04, 20);
  const Solution exact = modal_solution<double>(linear, times);
  const Solution explicit_one = solve_arkode_explicit(linear, times, {.relative = 1e-12});
  const Solution adams = solve_cvode_adams(linear, times, {.relative = 1e-12});
  std::printf("  Fehlberg %.1e, Adams %.1e\n", distance(explicit_one, exact),
              distance(adams, exact));
  CHECK_NEAR(distance(explicit_one, exact), 0.0, 1e-11);
  CHECK_NEAR(distance(adams, exact), 0.0, 1e-9);
}

TEST("double and long double modes agree to rounding") {
  const NetworkProblem network(sample::block({.nodes = 4}), overlapping_loads(0.3));
  const auto times = sample::instants(0.04, 20);
  const double error =
      distance(modal_solution<double>(network, times), modal_solution<long double>(network, times));
  std::printf("  %.1e\n", error);
  CHECK_NEAR(error, 0.0, 1e-11);  // positions of 1e-2 m carry motions of 1e-4 m, times the modes
}

TEST("the lattice itself tends to the modal solution in proportion to the amplitude") {
  double before = 0.0;
  for (const double newton : {1e-3, 1e-4}) {
    const NetworkProblem network(sample::block({.nodes = 3}), {sample::pulse(newton)});
    const auto times = sample::instants(0.03, 10);
    const double error = distance(
        solve_cvode_adams(
            network, times,
            {.relative = 1e-12, .position_scale = newton * 1e-3, .velocity_scale = newton * 1e-1}),
        modal_solution<double>(network, times));
    std::printf("  %g N: %.1e\n", newton, error);
    if (before > 0.0) { CHECK_NEAR(before / error, 10.0, 1.0); }
    before = error;
  }
  CHECK(before < 1e-3);
}

TEST("a free body under a constant push moves as a whole by F t^2 / 2 M") {
  auto body = sample::block({.nodes = 3, .viscosity = 0.0});
  std::ranges::fill(body.fixed, std::uint8_t{0});
  const Load push{.nodes = {0}, .force = {0.0, 0.0, 1e-4}};
  const NetworkProblem problem(body, {push});
  const double end = 0.05;
  const Solution solution = modal_solution<double>(problem, {0.0, end});
  const Eigen::VectorXd moved = solution.position.col(1) - solution.position.col(0);
  const double mass = body.mass.sum();
  const double centre = moved.dot(problem.mass().cwiseProduct(
                            Eigen::Vector3d(0.0, 0.0, 1.0).replicate(body.mass.size(), 1))) /
                        mass;
  CHECK_NEAR(centre / (1e-4 * end * end / (2.0 * mass)), 1.0, 1e-9);  // of positions of 1e-2 m
}

TEST("damping that is not proportional is refused with the coupling") {
  auto network = sample::block({.nodes = 3});
  network.springs.change_each([&](palpate::Spring& spring) {
    if (spring.a < 4) { spring.viscosity *= 3.0; }
  });
  const NetworkProblem problem(network, {sample::pulse(0.1)});
  CHECK_THROWS(modal_solution<double>(problem, {0.0, 0.01}), "not proportional");
}

TEST("a problem whose loads are not known in closed form is refused") {
  const NetworkProblem network(sample::block({.nodes = 2}));
  const sample::Wrapped unknown(network);
  CHECK_THROWS(modal_solution<double>(unknown, {0.0, 0.01}), "closed form");
}
