// SPDX-License-Identifier: MIT

#include "reference/haptic_loop.hpp"

#include <cmath>
#include <numbers>

#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using namespace palpate::reference;

TEST("without wall damping and delay the boundary is the closed form") {
  for (const double mass : {0.1, 0.2}) {
    for (const double b : {0.5, 2.0}) {
      const WallLoop loop{.mass = mass, .viscosity = b};
      const double tau = mass / b;
      const double a = std::exp(-loop.period / tau);
      const double closed = b * (1.0 - a) / (tau * (1.0 - a) - loop.period * a);
      // The closed form loses 2 log10(tau / T) digits to cancellation.
      CHECK_NEAR(critical_stiffness(loop) / closed, 1.0, 1e-9);
    }
  }
}

TEST("published digits of the boundary") {
  // Root locus of the same loop, from an independent computation; two decimals given.
  CHECK_NEAR(critical_stiffness({.mass = 0.1, .viscosity = 0.5}), 1000.83, 5e-3);
  CHECK_NEAR(critical_stiffness({.mass = 0.1, .viscosity = 0.5, .delay = 1}), 333.80, 5e-3);
  CHECK_NEAR(critical_stiffness({.mass = 0.1, .viscosity = 0.5, .damping = 1.0}), 2972.70, 5e-3);
  CHECK_NEAR(critical_stiffness({.mass = 0.1, .viscosity = 2.0, .damping = 1.0}), 5960.76, 5e-3);
}

TEST("the rules of thumb hold where they say, and too much wall damping leaves no stiffness") {
  const WallLoop light{.mass = 10.0, .viscosity = 0.5, .delay = 2};  // T much shorter than m / b
  CHECK_NEAR(linear_rule(light) / critical_stiffness(light), 1.0, 1e-3);
  CHECK_NEAR(passive_stiffness({.viscosity = 0.5}), 1000.0, 1e-9);
  CHECK(passive_stiffness({.viscosity = 0.5, .damping = 1.0}) < 0.0);
  CHECK_NEAR(quantised_stiffness({.viscosity = 5.0}, 5e-5, 0.08), 3200.0, 1e-9);
  CHECK(critical_stiffness({.mass = 0.1, .viscosity = 0.5, .damping = 500.0}) == 0.0);
}

/// One free node without springs.
SpringNetwork one_node(double mass) {
  SpringNetwork network;
  network.rest_position.setZero(3, 1);
  network.mass.setConstant(1, mass);
  network.fixed.assign(1, 0);
  return network;
}

/// Arms without inertia; only the hand moves the grip.
HeldTool hand_alone() {
  HeldTool held;
  held.legs = {
      .arm = 0.06,
      .shin = 0.1025,
      .link = 0.03,
      .radial = 0.0227,
      .base_lateral = 0.0,
      .effector_lateral = 0.0,
      .azimuth = {0.1, 0.1 + 2.0 * std::numbers::pi / 3.0, 0.1 - 2.0 * std::numbers::pi / 3.0}};
  held.grip_mass = 0.25;
  held.hand_stiffness = 400.0;
  held.motor_lag = 1e-3;
  held.tool_mass = 0.02;
  held.start = {0.0, 0.0, 0.12};
  held.intent = [](double, Eigen::Vector3d& place, Eigen::Vector3d& velocity) {
    place = {0.001, -0.002, 0.122};
    velocity.setZero();
  };
  return held;
}

constexpr Tolerance fine{.relative = 1e-10, .position_scale = 1e-3, .velocity_scale = 1e-2};

TEST("a grip on the hand's spring swings as a damped spring does") {
  const Eigen::Vector3d middle(0.001, -0.002, 0.122);
  const Eigen::Vector3d from(0.0, 0.0, 0.12);
  for (const double viscosity : {0.0, 4.0}) {
    HeldTool held = hand_alone();
    held.hand_viscosity = viscosity;
    const Trace motion = solve_held_tool(held, one_node(0.01), 300, fine);
    const double decay = viscosity / (2.0 * 0.25);
    const double omega = std::sqrt(1600.0 - decay * decay);
    for (std::size_t n = 0; n < motion.time.size(); ++n) {
      const double t = motion.time[n];
      const double swing =
          std::exp(-decay * t) * (std::cos(omega * t) + decay / omega * std::sin(omega * t));
      const Eigen::Vector3d grip(motion.at("device.x_m", n), motion.at("device.y_m", n),
                                 motion.at("device.z_m", n));
      CHECK_NEAR(grip, Eigen::Vector3d(middle + swing * (from - middle)), 1e-10);
      CHECK_NEAR(motion.at("tool.insertion_m", n), 0.0, 1e-15);
    }
  }
}

TEST("a held handle moves the tool as a spring and a damper between ticks, exactly sampled") {
  // Very stiff hand that keeps the grip fixed; the tool starts to move because of the offset of the
  // intent.
  HeldTool held = hand_alone();
  held.intent = [](double, Eigen::Vector3d& place, Eigen::Vector3d& velocity) {
    place = {0.0, 0.0, 0.12};
    velocity.setZero();
  };
  held.coupling_stiffness = 300.0;
  const palpate::Trace still = solve_held_tool(held, one_node(0.01), 50, fine);
  for (const double place : still.values("tool.insertion_m")) { CHECK_NEAR(place, 0.0, 1e-14); }
  for (const char* name : {"device.command_x_n", "device.command_y_n", "device.command_z_n"}) {
    for (const double force : still.values(name)) { CHECK_NEAR(force, 0.0, 1e-11); }
  }
}

TEST("derivatives carried through formulas are those of the formulas") {
  // f(t) = acos(sqrt(t)) / t at t = 1/4: f = 4 pi / 3, and by hand its derivatives.
  const Taylor t{0.25, 1.0, 0.0};
  const Taylor f = acos(sqrt(t)) * inverse(t);
  const double pi = std::numbers::pi;
  const double g = pi / 3.0;                              // acos(1/2)
  const double g1 = -1.0 / std::sqrt(0.25 * 0.75) / 2.0;  // -1 / (2 sqrt(t (1 - t)))
  const double g2 = (1.0 - 2.0 * 0.25) / 4.0 / std::pow(0.25 * 0.75, 1.5);
  CHECK_NEAR(f.value, 4.0 * pi / 3.0, 1e-14);
  CHECK_NEAR(f.first, 4.0 * g1 - 16.0 * g, 1e-13);
  CHECK_NEAR(f.second, 4.0 * g2 - 32.0 * g1 + 128.0 * g, 1e-12);
}

TEST("the angle of a point on a circle turns evenly") {
  const double w = 3.0;
  for (const double phase : {0.3, 1.2, 2.5}) {
    const Taylor x{2.0 * std::cos(phase), -2.0 * w * std::sin(phase),
                   -2.0 * w * w * std::cos(phase)};
    const Taylor y{2.0 * std::sin(phase), 2.0 * w * std::cos(phase),
                   -2.0 * w * w * std::sin(phase)};
    const Taylor turned = angle(y, x);
    CHECK_NEAR(turned.value, phase, 1e-15);
    CHECK_NEAR(turned.first, w, 1e-14);
    CHECK_NEAR(turned.second, 0.0, 1e-13);
  }
}

}  // namespace PALPATE_FILE
