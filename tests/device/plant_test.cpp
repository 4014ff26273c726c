// SPDX-License-Identifier: MIT
#include "device/falcon/plant.hpp"

#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "device/seeded.hpp"
#include "tests/check.hpp"

namespace {

using namespace palpate::device;
using namespace palpate::device::falcon;
using Vector = Eigen::Vector3d;

const Vector start(0.01, -0.005, 0.14);
const PlantOptions bare{.gravity = 0.0, .coulomb = 0.0, .viscosity = 0.0};

/// Where a second with a firm hand and changing torques ends.
Vector second(const PlantOptions& options, const std::vector<Action>& actions, double tremor) {
  Plant plant(Kinematics(), options);
  Motors motors;
  const Hand hand{
      .impedance = firm_hand,
      .intent = Intent(
          {.start = start, .direction = {0.1, 0.05, -1.0}, .actions = actions, .tremor = tremor})};
  plant.place(start, hand);
  for (int n = 0; n < 1000; ++n) {
    const double wave = 0.02 * std::sin(0.01 * n);
    motors.command_torque({0.1 * wave - 0.01, 0.01, wave - 0.02});
    plant.advance(1e-3, motors, hand);
  }
  return plant.position();
}

PlantOptions with_substep(double substep) {
  PlantOptions options;
  options.substep = substep;
  return options;
}

TEST("the plant converges at order four, through sticking and reversals too") {
  const std::vector<Action> smooth{Advance{0.03, 0.02, 0.2}};
  const std::vector<Action> reversing{Advance{0.02, 0.08, 0.1}, Withdraw{0.015, 0.08, 0.1}};
  for (const auto& [actions, tremor] : {std::pair{smooth, 0.0}, std::pair{reversing, 5e-5}}) {
    const Vector exact = second(with_substep(12.5e-6), actions, tremor);
    const double coarse = (second(with_substep(5e-4), actions, tremor) - exact).norm();
    const double fine = (second(with_substep(2.5e-4), actions, tremor) - exact).norm();
    const double chosen = (second({}, actions, tremor) - exact).norm();
    CHECK_NEAR(std::log2(coarse / fine), 4.0, 0.2);
    CHECK(chosen < 1e-9);
    std::printf("  error at 500 us %.2g m, 250 us %.2g m, default %.2g m\n", coarse, fine, chosen);
  }
}

TEST("the same calls end in the same bits") {
  const std::vector<Action> actions{Advance{0.02, 0.08, 0.1}, Withdraw{0.015, 0.08, 0.1}};
  const Vector once = second({}, actions, 5e-5);
  const Vector again = second({}, actions, 5e-5);
  CHECK(once == again);
}

TEST("below Coulomb friction the device rests to the bit, just above it moves") {
  for (const double share : {0.99, 1.01}) {
    Plant plant(Kinematics(), {.gravity = 0.0});
    Motors motors;
    const Hand nobody{.impedance = no_hand};
    plant.place(start, nobody);
    motors.command_torque(Vector::Constant(share * 4e-3));
    for (int n = 0; n < 2000; ++n) { plant.advance(1e-3, motors, nobody); }
    CHECK((plant.position() == start) == (share < 1.0));
    if (share > 1.0) { CHECK(plant.position().z() > start.z() + 1e-3); }
  }
}

TEST("a moving device that is left alone comes to rest and stays there to the bit") {
  Plant plant(Kinematics(), {.gravity = 0.0});
  Motors motors;
  const Hand nobody{.impedance = no_hand};
  plant.place(Kinematics::centre(), nobody, {0.05, -0.08, 0.06});
  for (int n = 0; n < 1000; ++n) { plant.advance(1e-3, motors, nobody); }
  const Vector there = plant.position();
  CHECK(plant.velocity() == Vector::Zero());
  for (int n = 0; n < 1000; ++n) { plant.advance(1e-3, motors, nobody); }
  CHECK(plant.position() == there);
}

TEST("a medium hand holds the device without drift") {
  Plant plant;
  Motors motors;
  const Hand hand{.intent = Intent({.start = start})};
  plant.place(start + Vector(0.002, 0.001, -0.003), hand);
  for (int n = 0; n < 3000; ++n) { plant.advance(1e-3, motors, hand); }
  const Vector there = plant.position();
  // Weight sags it by m g / k; friction keeps it within its force, 0.2 N, over k from there.
  CHECK_NEAR(there, Vector(start - Vector(0.0, 0.13 * 9.80665 / 400.0, 0.0)), 0.2 / 400.0);
  for (int n = 0; n < 3000; ++n) { plant.advance(1e-3, motors, hand); }
  CHECK(plant.position() == there);
}

TEST("arms weigh at the centre what was computed from the mechanism: 172 and 523 per m^2") {
  const Eigen::Matrix3d slope = inverse_jacobian(*Kinematics().legs(Kinematics::centre()));
  const Eigen::Matrix3d added = slope.transpose() * slope;
  CHECK_NEAR(added.diagonal(), Vector(172.0, 172.0, 523.0), 3.0);
  // And a force then accelerates the mass and the arms.
  Plant plant(Kinematics(), bare);
  Motors motors(MotorOptions{.time_constant = 0.0});
  const Hand nobody{.impedance = no_hand};
  for (int axis = 0; axis < 3; ++axis) {
    plant.place(Kinematics::centre(), nobody);
    const Eigen::Matrix3d J = *Kinematics().jacobian(Kinematics::centre());
    motors.command_torque(torque_of_force(J, Vector::Unit(axis)));
    plant.advance(1e-4, motors, nobody);
    const double mass = 0.13 + 4e-4 * added(axis, axis);
    CHECK_NEAR(plant.velocity()[axis], 1e-4 / mass, 1e-9);  // the force turns by 1e-9 on the way
  }
}

TEST("without arms and friction the grip falls freely") {
  PlantOptions options = bare;
  options.arm_inertia = 0.0;
  options.gravity = 9.80665;
  Plant plant(Kinematics(), options);
  Motors motors;
  const Hand nobody{.impedance = no_hand};
  plant.place({0.0, 0.02, 0.125}, nobody);
  for (int n = 0; n < 80; ++n) { plant.advance(1e-3, motors, nobody); }
  CHECK_NEAR(plant.position().y(), 0.02 - 0.5 * 9.80665 * 0.0064, 1e-14);
}

TEST("the hand's mass is carried and the tool's weighs") {
  PlantOptions options = bare;
  options.arm_inertia = 0.0;
  options.gravity = 10.0;
  options.tool_mass = 0.07;
  Plant plant(Kinematics(), options);
  Motors motors;
  const Hand limp{.impedance = {.mass = 0.2, .viscosity = 0.0, .stiffness = 0.0}};
  plant.place({0.0, 0.02, 0.125}, limp);
  for (int n = 0; n < 50; ++n) { plant.advance(1e-3, motors, limp); }
  CHECK_NEAR(plant.velocity().y(), -0.05 * 10.0 * (0.13 + 0.07) / (0.13 + 0.07 + 0.2), 1e-13);
}

TEST("full torque ends at the stops, strained as their stiffness says") {
  for (const double direction : {1.0, -1.0}) {
    Plant plant(Kinematics(), {.gravity = 0.0, .elbow_stop = 0.0});
    Motors motors;
    const Hand nobody{.impedance = no_hand};
    plant.place(Kinematics::centre(), nobody);
    motors.command_torque(Vector::Constant(direction * 0.3));
    for (int n = 0; n < 3000; ++n) { plant.advance(1e-3, motors, nobody); }
    const PlantOptions& options = plant.mechanics().options();
    const double stop = direction > 0.0 ? options.outer_stop : options.inner_stop;
    const double strain = 0.3 / options.stop_stiffness;
    const double slack = options.coulomb / options.stop_stiffness;
    CHECK_NEAR(plant.theta1(), Vector::Constant(stop + direction * strain), 1.01 * slack);
    CHECK(plant.halts() == 0);
  }
}

TEST("no motor command drives the mechanism out of its reach") {
  Plant plant;
  Motors motors;
  const Hand nobody{.impedance = no_hand};
  Seeded seeded(9);
  for (int n = 0; n < 5000; ++n) {
    if (n % 100 == 0) {
      Vector torque;
      for (double& each : torque) { each = seeded.uniform(-1.0, 1.0) > 0.0 ? 0.619 : -0.619; }
      motors.command_torque(torque);
    }
    plant.advance(1e-3, motors, nobody);
    CHECK(plant.mechanics().kinematics().legs(plant.position()).has_value());
  }
  CHECK(plant.halts() <= 10);  // of 100,000 substeps with full torque either way
}

TEST("with an arm behind it the hand gives way further") {
  double pushed_back[2];
  for (const bool arm : {false, true}) {
    Plant plant;
    Motors motors;
    Hand hand{.intent = Intent({.start = start})};
    if (arm) { hand.arm = arm_stage; }
    plant.place(start, hand);
    const Eigen::Matrix3d J = *Kinematics().jacobian(start);
    motors.command_torque(torque_of_force(J, {0.0, 0.0, 1.0}));
    for (int n = 0; n < 4000; ++n) { plant.advance(1e-3, motors, hand); }
    pushed_back[arm ? 1 : 0] = plant.position().z() - start.z();
  }
  // 1 N over 400 N/m, and over 135 N/m in series; Coulomb friction of up to 0.2 N holds some back.
  CHECK_NEAR(pushed_back[0], 1.0 / 400.0, 0.3 / 400.0);
  CHECK_NEAR(pushed_back[1], 1.0 / 400.0 + 1.0 / 135.0, 0.3 * (1.0 / 400.0 + 1.0 / 135.0));
}

TEST("a place beyond reach is refused and changes nothing") {
  Plant plant;
  const Vector before = plant.position();
  CHECK(!plant.place({0.0, 0.0, 0.4}, Hand{}));
  CHECK(plant.position() == before);
}

}  // namespace
