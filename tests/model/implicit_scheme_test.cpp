// SPDX-License-Identifier: MIT
#include "model/stepping/integrators/implicit_scheme.hpp"

#include <cmath>

#include "model/dynamics/lattice.hpp"
#include "model/stepping/oscillator_system.hpp"
#include "model/stepping/simulation.hpp"
#include "tests/check.hpp"

namespace {

using namespace palpate;

/// Damped 3 x 3 x 3 lattice with one node pushed by `push` [m].
SpringNetwork pushed_lattice(double push) {
  SpringNetwork network = uniform_lattice({{3, 3, 3}, 0.005, 26}, 50.0, 0.5, 1e-3);
  for (std::size_t i = 18; i < 27; ++i) { network.fixed[i] = 1; }
  network.initial_displacement = NodeVectors::Zero(3, 27);
  network.initial_displacement(2, 4) = push;
  return network;
}

TEST("damped tissue comes to rest and stays there, in either precision") {
  for (const char* name : {"implicit-euler", "implicit-midpoint"}) {
    for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
      for (const double push : {1e-12, 1e-9, 1e-6, 1e-3}) {
        Scene scene;
        scene.simulation = {.duration = 2.0,
                            .step = 1e-3,
                            .substeps = 1,
                            .integrator = name,
                            .precision = precision};
        scene.tissue.source = Source::network;
        Simulation simulation(scene, pushed_lattice(push));
        StepStatus status = StepStatus::ok;
        for (int n = 0; n < 2000 && status == StepStatus::ok; ++n) { status = simulation.tick(); }
        CHECK(status == StepStatus::ok);
        // What is left are roundings of positions of 0.01 m: 1e-18 m, or 1e-9 m in float.
        const double rounding = precision == Precision::single_precision ? 1e-8 : 1e-16;
        const NodeVectors place = simulation.node_positions();
        CHECK_NEAR(place, pushed_lattice(0.0).rest_position, rounding);
      }
    }
  }
}

/// Where a node is that a force hits at `start`, 20 ticks later. It stretches its springs by half.
Eigen::Vector3d place_after_a_blow(double start, const char* integrator) {
  Scene scene;
  scene.simulation = {.duration = start + 0.02, .step = 1e-3, .substeps = 1, .integrator = integrator};
  scene.tissue.source = Source::network;
  scene.loads = {{.nodes = {4}, .force = {0.1, 0.2, 0.3}, .start = start}};
  Simulation simulation(scene, pushed_lattice(0.0));
  while (simulation.ticks() < simulation.tick_count()) { CHECK(simulation.tick() == StepStatus::ok); }
  return simulation.node_positions().col(4);
}

TEST("a blow after a rest is solved as closely as one at once") {
  for (const char* name : {"implicit-euler", "implicit-midpoint"}) {
    const Eigen::Vector3d at_once = place_after_a_blow(0.0, name);
    CHECK((at_once - pushed_lattice(0.0).rest_position.col(4)).norm() > 1e-3);
    CHECK_NEAR(place_after_a_blow(0.1, name), at_once, 1e-12);
  }
}

/// Stiff blocks in soft tissue that is pressed to half its height and buckles: far from linear in every step.
StepStatus press_mixed_block(double force) {
  SpringNetwork network = uniform_lattice({{5, 5, 6}, 0.003, 26}, 60.0, 0.3, 3e-5);
  for (std::size_t i = 0; i < 25; ++i) { network.fixed[i] = 1; }
  network.springs.change_each([&](Spring& spring) {
    const bool stiff = spring.a / 25 == 3 && spring.b / 25 == 3;
    if (stiff) { spring.stiffness = 6e5; }
  });
  Scene scene;
  scene.simulation = {.duration = 0.05, .step = 1e-3, .substeps = 1, .integrator = "implicit-euler"};
  scene.tissue.source = Source::network;
  scene.loads = {{.nodes = {137}, .force = {0.0, 0.3 * force, -force}}};
  Simulation simulation(scene, network);
  StepStatus status = StepStatus::ok;
  while (status == StepStatus::ok && simulation.ticks() < simulation.tick_count()) { status = simulation.tick(); }
  return status;
}

TEST("steps far from linear find their solution with part of a correction") {
  for (const double force : check::sanitized ? std::vector{0.8} : std::vector{0.2, 0.4, 0.8}) {
    CHECK(press_mixed_block(force) == StepStatus::ok);
  }
}

/// Position and velocity after one step on m = 1.
State<double> one_step(double theta, const Oscillator& o, double h) {
  OscillatorSystem<double> system(o);
  State<double> state{Eigen::VectorXd::Constant(1, o.displacement),
                      Eigen::VectorXd::Constant(1, o.velocity)};
  ImplicitScheme<double> scheme(theta);
  scheme.prepare(system, state, h);
  scheme.step(system, state, 0.0, h);
  return state;
}

TEST("one step on an oscillator is its closed form at any step length") {
  const Oscillator o{
      .mass = 1.0, .stiffness = 4.0, .viscosity = 0.6, .displacement = 0.3, .velocity = -0.8};
  for (const double theta : {1.0, 0.5}) {
    for (const double h : {1e-6, 1e-3, 0.1, 1.0, 1e3, 1e6}) {
      // (1 + theta h c + (theta h)^2 k) D = -h (k (x + theta h v) + c v)
      const double change = -h * (4.0 * (0.3 - theta * h * 0.8) - 0.6 * 0.8) /
                            (1.0 + theta * h * 0.6 + theta * theta * h * h * 4.0);
      const State<double> end = one_step(theta, o, h);
      CHECK_NEAR(end.velocity(0), -0.8 + change, 1e-13);
      CHECK_NEAR(end.position(0) / h, 0.3 / h - 0.8 + theta * change, 1e-13 * (1.0 + 0.3 / h));
    }
  }
}

TEST("the same to the same digits at amplitudes far from one") {
  for (const double theta : {1.0, 0.5}) {
    const Oscillator unit{.mass = 1.0, .stiffness = 4.0, .viscosity = 0.6, .displacement = 1.0};
    const double expected = one_step(theta, unit, 0.1).position(0);
    for (const double size : {1e-300, 1e-200, 1e-30, 1e30, 1e150, 1e200}) {
      Oscillator o = unit;
      o.displacement = size;
      CHECK_NEAR(one_step(theta, o, 0.1).position(0) / size, expected, 1e-13);
    }
  }
}

}  // namespace
