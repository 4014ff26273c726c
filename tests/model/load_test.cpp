// SPDX-License-Identifier: MIT
#include <cmath>
#include <numbers>

#include "model/stepping/simulation.hpp"
#include "tests/check.hpp"

namespace {

using namespace palpate;

constexpr double mass = 0.02;

TEST("a load acts where its gate lies in [start, end): the start counts, the end does not") {
  const Load load{.start = 0.25, .end = 0.5};
  CHECK(load_factor(load, 0.25, 0.25) == 1.0);
  CHECK(load_factor(load, 0.25, std::nextafter(0.25, 0.0)) == 0.0);
  CHECK(load_factor(load, 0.5, std::nextafter(0.5, 0.0)) == 1.0);
  CHECK(load_factor(load, 0.5, 0.5) == 0.0);
}

TEST("the gate decides whether a load acts, the time decides how strongly") {
  const Load ramp{.start = 1.0, .end = 3.0, .profile = Profile::ramp};
  CHECK_NEAR(load_factor(ramp, 3.0, 2.5), 1.0, 1e-15);
  CHECK_NEAR(load_factor(ramp, 1.5, 1.5), 0.25, 1e-15);
  const Load sine{.start = 1.0, .end = 3.0, .profile = Profile::half_sine};
  CHECK_NEAR(load_factor(sine, 1.5, 1.5), std::sin(std::numbers::pi / 4.0), 1e-15);
  CHECK_NEAR(load_factor(sine, 3.0, 2.0), 0.0, 1e-15);
}

TEST("a load without an end never ends") { CHECK(load_factor(Load{}, 1e12, 1e12) == 1.0); }

/// Velocity of a free mass after the run, in units of what one step's impulse gives it.
double impulses(const IntegratorInfo& scheme, const Load& load, double step, int ticks,
                int substeps = 1) {
  Scene scene;
  scene.simulation = {.duration = ticks * step,
                      .step = step,
                      .substeps = substeps,
                      .integrator = std::string(scheme.name)};
  scene.tissue.source = Source::network;
  SpringNetwork& network = scene.tissue.network;
  network.rest_position = NodeVectors::Zero(3, 1);
  network.mass = Eigen::VectorXd::Constant(1, mass);
  network.fixed = {0};
  scene.loads = {load};
  Simulation simulation(scene);
  for (int n = 0; n < ticks; ++n) { (void)simulation.tick(); }
  Eigen::VectorXd v(3);
  simulation.velocities(v);
  return v(2) * mass * substeps / step;
}

Load push(double start, double end) {
  return {.nodes = {0}, .force = {0, 0, 1}, .start = start, .end = end};
}

// Each step adds round-off of its own size, so n steps agree to a few n units of rounding.
TEST("every scheme gives one step's impulse for each step that begins in [start, end)") {
  for (const IntegratorInfo* scheme : integrators()) {
    CHECK_NEAR(impulses(*scheme, push(2e-3, 5e-3), 1e-3, 10), 3.0, 1e-12);
    CHECK_NEAR(impulses(*scheme, push(2.5e-3, 4.5e-3), 1e-3, 10), 2.0, 1e-12);  // 3, 4
    CHECK_NEAR(impulses(*scheme, push(2.1e-3, 2.9e-3), 1e-3, 10), 0.0, 1e-12);  // none begins there
    CHECK_NEAR(impulses(*scheme, push(0.0, 1.0), 1e-3, 10), 10.0, 1e-12);
    CHECK_NEAR(impulses(*scheme, push(2e-3, 5e-3), 1e-3, 10, 4), 12.0, 1e-12);  // of the integrator
  }
}

TEST("rounding of the time never moves a load by a step") {
  for (const IntegratorInfo* scheme : integrators()) {
    CHECK_NEAR(impulses(*scheme, push(0.3, 0.7), 0.1, 10), 4.0, 1e-12);  // 3 * 0.1 > 0.3 in binary
    CHECK_NEAR(impulses(*scheme, push(0.6, 0.9), 0.1, 10), 3.0, 1e-12);
  }
}

TEST("a half-sine load gives the impulse of its area") {
  Load pulse = push(0.0, 0.1);
  pulse.profile = Profile::half_sine;
  // Trapezium rule of 100 panels on a sine: relative error pi^2 / 12 / 100^2 = 8.2e-5.
  const double area = 100.0 * 2.0 / std::numbers::pi;
  for (const char* name : {"velocity-verlet", "rk4", "implicit-midpoint", "leapfrog"}) {
    CHECK_NEAR(impulses(*find_integrator(name), pulse, 1e-3, 110) / area, 1.0, 1e-4);
  }
}

TEST("breaks of a problem are the switching instants, sorted, once each") {
  SpringNetwork network;
  network.rest_position = NodeVectors::Zero(3, 1);
  network.mass = Eigen::VectorXd::Ones(1);
  network.fixed = {0};
  const NetworkProblem problem(network, {push(0.4, 0.5), push(0.0, 0.4), push(0.1, Load{}.end)});
  const std::vector<double> expected{0.1, 0.4, 0.5};
  CHECK(problem.breaks() == expected);
  CHECK_NEAR(problem.shortest_feature(), 0.1, 1e-15);
}

}  // namespace
