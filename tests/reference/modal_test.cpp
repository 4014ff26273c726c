// SPDX-License-Identifier: MIT

#include "reference/modal.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "reference/exact_problems.hpp"
#include "reference/solver_cross_check.hpp"
#include "reference/solvers.hpp"
#include "tests/check.hpp"
#include "tests/reference/sample_problems.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using namespace palpate::reference;

/// Equation of motion integrated by classical RK4 in long double: slow, but independent of
/// resonance and damping regime.
ModeState<long double> stepped(const Mode<long double>& mode, ModeState<long double> y,
                               const ModeForce<long double>& force, long double end) {
  using State = ModeState<long double>;
  const auto rate = [&](long double t, const State& s) {
    long double p = force.constant + force.slope * t;
    for (const auto& h : force.harmonics) {
      p += h.cosine * std::cos(h.frequency * t) + h.sine * std::sin(h.frequency * t);
    }
    return State{s.velocity, p - 2 * mode.gamma * s.velocity - mode.omega_squared * s.position};
  };
  const auto moved = [](const State& s, const State& r, long double h) {
    return State{s.position + h * r.position, s.velocity + h * r.velocity};
  };
  const int steps = 50 + static_cast<int>(5000 * end);
  const long double h = end / steps;
  for (int n = 0; n < steps; ++n) {
    const long double t = n * h;
    const State a = rate(t, y);
    const State b = rate(t + h / 2, moved(y, a, h / 2));
    const State c = rate(t + h / 2, moved(y, b, h / 2));
    const State d = rate(t + h, moved(y, c, h));
    y.position += h / 6 * (a.position + 2 * b.position + 2 * c.position + d.position);
    y.velocity += h / 6 * (a.velocity + 2 * b.velocity + 2 * c.velocity + d.velocity);
  }
  return y;
}

template <class Real> ModeForce<Real> all_shapes(Real frequency) {
  return {.constant = Real(0.7),
          .slope = Real(-0.4),
          .harmonics = {{frequency, Real(0.3), Real(-0.8)}, {Real(0.5), Real(0.1), Real(0.2)}}};
}

struct Case {
  double omega_squared, gamma, frequency, t;
};

template <class Real> double error(const Case& c, const ModeState<long double>& truth) {
  const auto exact = respond<Real>({Real(c.omega_squared), Real(c.gamma)}, {Real(0.5), Real(-1.25)},
                                   all_shapes<Real>(Real(c.frequency)), Real(c.t));
  const long double size = 1 + std::abs(truth.position) + std::abs(truth.velocity);
  return static_cast<double>(std::fmax(std::abs(exact.position - truth.position),
                                       std::abs(exact.velocity - truth.velocity)) /
                             size);
}

TEST("the response to every shape of load solves the equation of motion in every regime") {
  // omega^2 < 0 (unstable), 0 (rigid), near 0, and up; gamma through critical damping; the second
  // harmonic stays, the first sweeps through resonance at 3 rad/s.
  for (const double omega_squared : {-0.5, 0.0, 1e-9, 9.0}) {
    for (const double gamma : {0.0, 0.5, 3.0000001, 8.0}) {
      for (const double frequency : {0.1, 2.999, 3.0, 12.0}) {
        for (const double t : {1e-3, 0.6, 4.0}) {
          const Case c{omega_squared, gamma, frequency, t};
          const auto truth = stepped({omega_squared, gamma}, {0.5L, -1.25L},
                                     all_shapes<long double>(frequency), t);
          CHECK_NEAR(error<double>(c, truth), 0.0, 2e-13);
          CHECK_NEAR(error<long double>(c, truth), 0.0, 2e-13);
        }
      }
    }
  }
}

TEST("resonance grows with time, a rigid mode falls freely, and strong damping does not overflow") {
  const double t = 40.0;
  const auto resonant = respond<double>({9.0, 0.0}, {}, {.harmonics = {{3.0, 0.0, 1.0}}}, t);
  const double exact = (std::sin(3.0 * t) - 3.0 * t * std::cos(3.0 * t)) / (2.0 * 9.0);
  CHECK_NEAR(resonant.position, exact, 1e-12);  // 120 rad of phase, some 1e-14 each
  const auto rigid = respond<double>({0.0, 0.0}, {1.0, 2.0}, {.constant = -9.81}, 3.0);
  CHECK_NEAR(rigid.position, 1.0 + 6.0 - 9.81 * 4.5, 1e-13);
  CHECK_NEAR(rigid.velocity, 2.0 - 9.81 * 3.0, 1e-13);
  const auto damped = free_response<double>({1.0, 1e4}, {1.0, 0.0}, 100.0);
  CHECK_NEAR(damped.position, std::exp(-100.0 / 2e4), 1e-8);  // slow rate omega^2 / 2 gamma
}

double distance(const Trace& a, const Trace& b) {
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

TEST("chains fixed at one end and at both have their exact natural frequencies") {
  for (const bool both_ends : {false, true}) {
    const int n = both_ends ? 9 : 12;
    const NetworkProblem problem(sample::chain(n, 50.0, 2e-3, both_ends));
    const Eigen::VectorXd omega = natural_frequencies(problem);
    for (int j = 1; j <= n; ++j) {
      const double share = both_ends ? j / (n + 1.0) : (2.0 * j - 1.0) / (2.0 * n + 1.0);
      const double exact = 2.0 * std::sqrt(50.0 / 2e-3) * std::sin(share * std::numbers::pi / 2.0);
      CHECK_NEAR(omega(2 * n + j - 1) / exact, 1.0, 1e-12);  // 2 n sideways motions come first
    }
    CHECK_NEAR(omega(2 * n - 1) / omega(3 * n - 1), 0.0, 1e-7);  // the root of rounding
  }
}

TEST("modal superposition solves the linearised lattice under all shapes of load") {
  const NetworkProblem network(sample::block({.nodes = 4}), overlapping_loads(0.3),
                               {0.0, 0.0, 9.81});
  const LinearProblem linear(network);
  const auto times = sample::instants(0.04, 20);
  const Trace exact = solve_modal(linear, times, {});
  const Trace explicit_one = solve_arkode_explicit(linear, times, {.relative = 1e-12});
  const Trace adams = solve_cvode_adams(linear, times, {.relative = 1e-12});
  CHECK_NEAR(distance(explicit_one, exact), 0.0, 1e-11);
  CHECK_NEAR(distance(adams, exact), 0.0, 1e-9);
}

TEST("double and long double modes agree to rounding") {
  const NetworkProblem network(sample::block({.nodes = 4}), overlapping_loads(0.3));
  const auto times = sample::instants(0.04, 20);
  const double error =
      distance(solve_modal(network, times, {}), solve_modal_long_double(network, times, {}));
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
        solve_modal(network, times, {}));
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
  const Trace solution = solve_modal(problem, {0.0, end}, {});
  const Eigen::VectorXd moved = solution.position.col(1) - solution.position.col(0);
  const double mass = body.mass.sum();
  const double centre = moved.dot(problem.mass().cwiseProduct(
                            Eigen::Vector3d(0.0, 0.0, 1.0).replicate(body.mass.size(), 1))) /
                        mass;
  CHECK_NEAR(centre / (1e-4 * end * end / (2.0 * mass)), 1.0, 1e-9);  // for positions of 1e-2 m
}

TEST("damping that is not proportional, and loads without a closed form, are refused") {
  auto network = sample::block({.nodes = 3});
  network.springs.change_each([&](Spring& spring) {
    if (spring.a < 4) { spring.viscosity *= 3.0; }
  });
  const NetworkProblem problem(network, {sample::pulse(0.1)});
  CHECK_THROWS(solve_modal(problem, {0.0, 0.01}, {}), "not proportional");
  const NetworkProblem sound(sample::block({.nodes = 2}));
  CHECK_THROWS(solve_modal(DerivedProblem(sound), {0.0, 0.01}, {}), "closed form");
}

}  // namespace PALPATE_FILE
