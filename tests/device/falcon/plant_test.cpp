// SPDX-License-Identifier: MIT

#include "device/falcon/plant.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "device/falcon/emulated_falcon.hpp"
#include "device/seeded.hpp"
#include "tests/check.hpp"

namespace {

using namespace palpate::device::falcon;
constexpr double limit = 4e-3;

/// Random arms; their mobility is that of a positive mass.
ArmDynamics random_arms(palpate::device::Seeded& seeded, double push) {
  Eigen::Matrix3d any;
  ArmDynamics arms;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) { any(i, j) = seeded.uniform(-1.0, 1.0); }
    arms.free[i] = seeded.uniform(-push, push);
  }
  arms.mobility = 1000.0 * (any * any.transpose() + 0.1 * Eigen::Matrix3d::Identity());
  return arms;
}

TEST("sliding arms feel the limit against their motion") {
  palpate::device::Seeded seeded(1);
  const ArmDynamics arms = random_arms(seeded, 10.0);
  CHECK_NEAR(friction_torque(arms, {1, -1, 1}, limit), Eigen::Vector3d(-limit, limit, -limit), 0.0);
}

TEST("what holds the stuck arms leaves them without acceleration") {
  palpate::device::Seeded seeded(2);
  for (int n = 0; n < 100; ++n) {
    const ArmDynamics arms = random_arms(seeded, 10.0);
    for (const Slip& slip : {Slip{0, 0, 0}, Slip{0, 1, 0}, Slip{-1, 0, 1}}) {
      const Eigen::Vector3d acceleration =
          arms.free + arms.mobility * friction_torque(arms, slip, limit);
      for (int i = 0; i < 3; ++i) {
        if (slip[static_cast<std::size_t>(i)] == 0) { CHECK_NEAR(acceleration[i], 0.0, 1e-10); }
      }
    }
  }
}

TEST("arms at rest always find one lawful answer, stuck, sliding or mixed") {
  palpate::device::Seeded seeded(3);
  std::array<int, 4> stuck_count{};
  for (int n = 0; n < 4000; ++n) {
    const ArmDynamics arms = random_arms(seeded, n % 2 == 0 ? 6.0 : 30.0);
    const Slip slip = settled(arms, {0, 0, 0}, limit);
    const Eigen::Vector3d torque = friction_torque(arms, slip, limit);
    const Eigen::Vector3d acceleration = arms.free + arms.mobility * torque;
    int stuck = 0;
    for (std::size_t leg = 0; leg < 3; ++leg) {
      const auto i = static_cast<Eigen::Index>(leg);
      CHECK(std::abs(torque[i]) <= limit * (1.0 + 1e-9));
      CHECK((slip[leg] == 0 ? std::abs(acceleration[i]) < 1e-9
                            : slip[leg] * acceleration[i] > -1e-9));
      stuck += slip[leg] == 0 ? 1 : 0;
    }
    ++stuck_count[static_cast<std::size_t>(stuck)];
  }
  for (const int count : stuck_count) { CHECK(count > 50); }  // the sample meets every case
}

TEST("arms that move are not touched") {
  palpate::device::Seeded seeded(4);
  for (int n = 0; n < 100; ++n) {
    const Slip slip = settled(random_arms(seeded, 30.0), {1, 0, -1}, limit);
    CHECK(slip[0] == 1);
    CHECK(slip[2] == -1);
  }
}

using namespace palpate::device;
using Vector = Eigen::Vector3d;

const Vector grip_start(0.01, -0.005, 0.14);
const PlantOptions bare{.gravity = 0.0, .coulomb = 0.0, .viscosity = 0.0};

/// Final state after one second with a firm hand and changing torques.
Vector second(const PlantOptions& options, const std::vector<Action>& actions, double tremor) {
  Plant plant(Kinematics(), options);
  Motors motors;
  const Hand hand{.impedance = firm_hand,
                  .intent = Intent({.start = grip_start,
                                    .direction = {0.1, 0.05, -1.0},
                                    .actions = actions,
                                    .tremor = tremor})};
  plant.place(grip_start, hand);
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
    plant.place(grip_start, nobody);
    motors.command_torque(Vector::Constant(share * 4e-3));
    for (int n = 0; n < 2000; ++n) { plant.advance(1e-3, motors, nobody); }
    CHECK((plant.position() == grip_start) == (share < 1.0));
    if (share > 1.0) { CHECK(plant.position().z() > grip_start.z() + 1e-3); }
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
  const Hand hand{.intent = Intent({.start = grip_start})};
  plant.place(grip_start + Vector(0.002, 0.001, -0.003), hand);
  for (int n = 0; n < 3000; ++n) { plant.advance(1e-3, motors, hand); }
  const Vector there = plant.position();
  // Gravity displaces it by m g / k; friction limits the deviation to its force, 0.2 N, over k.
  CHECK_NEAR(there, Vector(grip_start - Vector(0.0, 0.13 * 9.80665 / 400.0, 0.0)), 0.2 / 400.0);
  for (int n = 0; n < 3000; ++n) { plant.advance(1e-3, motors, hand); }
  CHECK(plant.position() == there);
}

TEST("arms weigh at the centre what was computed from the mechanism: 172 and 523 per m^2") {
  const Eigen::Matrix3d slope = inverse_jacobian(*Kinematics().legs(Kinematics::centre()));
  const Eigen::Matrix3d added = slope.transpose() * slope;
  CHECK_NEAR(added.diagonal(), Vector(172.0, 172.0, 523.0), 3.0);
  // A force then accelerates the mass and the arms.
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
    Hand hand{.intent = Intent({.start = grip_start})};
    if (arm) { hand.arm = arm_stage; }
    plant.place(grip_start, hand);
    const Eigen::Matrix3d J = *Kinematics().jacobian(grip_start);
    motors.command_torque(torque_of_force(J, {0.0, 0.0, 1.0}));
    for (int n = 0; n < 4000; ++n) { plant.advance(1e-3, motors, hand); }
    pushed_back[arm ? 1 : 0] = plant.position().z() - grip_start.z();
  }
  // 1 N over 400 N/m, and over 135 N/m in series; Coulomb friction of up to 0.2 N reduces it.
  CHECK_NEAR(pushed_back[0], 1.0 / 400.0, 0.3 / 400.0);
  CHECK_NEAR(pushed_back[1], 1.0 / 400.0 + 1.0 / 135.0, 0.3 * (1.0 / 400.0 + 1.0 / 135.0));
}

TEST("a place beyond reach is refused and changes nothing") {
  Plant plant;
  const Vector before = plant.position();
  CHECK(!plant.place({0.0, 0.0, 0.4}, Hand{}));
  CHECK(plant.position() == before);
}

const Hand nobody{.impedance = no_hand};

TEST("without friction and motors the energy is conserved while the arms swing") {
  // Heavy arms on a light grip, so that the velocity-dependent term dominates; only a spring
  // reverses the motion.
  const double stiffness = 200.0;
  const Hand spring{.impedance = {.mass = 0.0, .viscosity = 0.0, .stiffness = stiffness}};
  const PlantOptions heavy_arms{
      .effector_mass = 0.02, .arm_inertia = 2e-3, .coulomb = 0.0, .viscosity = 0.0};
  Plant plant(Kinematics(), heavy_arms);
  Motors motors;
  plant.place({0.02, 0.015, 0.145}, spring);
  const auto stored = [&] {
    const EnergyAudit energy = plant.energy(spring);
    const Vector stretch = plant.position() - Kinematics::centre();
    return energy.kinetic + energy.potential + 0.5 * stiffness * stretch.squaredNorm();
  };
  const double first = stored();
  double largest = 0.0;
  double fastest = 0.0;
  for (int n = 0; n < 2000; ++n) {
    plant.advance(1e-3, motors, spring);
    largest = std::max(largest, std::abs(stored() / first - 1.0));
    fastest = std::max(fastest, plant.velocity().norm());
  }
  CHECK(fastest > 0.3);
  CHECK(plant.energy(spring).stop_loss == 0.0);
  // Order four: (omega h)^4 / 120 a radian, omega some 50/s, h = 50 us. A hundredth of the term:
  // 3e-3.
  CHECK_NEAR(largest, 0.0, 1e-11);
  std::printf("  largest share of energy gained or lost %.2g at %.2g m/s\n", largest, fastest);
}

TEST("every joule is accounted for: motors, hand, weight, friction and stops") {
  for (const bool stops : {false, true}) {
    Plant plant;
    Motors motors;
    const Vector held_at(0.01, -0.005, 0.14);
    const Hand hand{
        .impedance = firm_hand,
        .intent = Intent(
            {.start = held_at, .actions = {Advance{0.03, 0.05, 0.1}, Withdraw{0.03, 0.05, 0.1}}})};
    plant.place(held_at, hand);
    for (int n = 0; n < 1500; ++n) {
      const double push = stops && n > 500 ? 0.5 : 0.0;
      motors.command_torque({push - 0.01, push + 0.02 * std::sin(0.05 * n), push});
      plant.advance(1e-3, motors, hand);
    }
    const EnergyAudit energy = plant.energy(hand);
    CHECK(energy.friction_loss > 1e-4);
    CHECK(std::abs(energy.motor_work) > 1e-5);
    CHECK(stops == (energy.stop_loss > 1e-6));
    // Order four, except for the step with contact at a stop: there the damper force jumps, by 1e-4
    // of its later value.
    CHECK_NEAR(energy.imbalance(), 0.0, stops ? 1e-4 * energy.stop_loss : 1e-11);
    std::printf("  imbalance %.2g J of %.2g J lost\n", energy.imbalance(),
                energy.friction_loss + energy.stop_loss);
  }
}

TEST("with commands of zero the device is passive") {
  Plant plant;
  Motors motors;
  plant.place({0.0, 0.02, 0.13}, nobody, {0.2, 0.1, -0.3});
  double before = plant.energy(nobody).kinetic + plant.energy(nobody).potential;
  for (int n = 0; n < 3000; ++n) {
    plant.advance(1e-3, motors, nobody);
    const EnergyAudit energy = plant.energy(nobody);
    CHECK(energy.motor_work == 0.0);
    const double now = energy.kinetic + energy.potential;
    CHECK(now <= before + 1e-9);  // the integrator's share at the stops
    before = now;
  }
}

TEST("what a hand cannot have put in, it cannot get out: energy decays in every grip") {
  for (const HandImpedance& impedance : {light_hand, medium_hand, firm_hand}) {
    Plant plant(Kinematics(), {.gravity = 0.0});
    Motors motors;
    const Hand hand{.impedance = impedance};
    plant.place({0.01, 0.01, 0.135}, hand);
    const auto stored = [&] {
      const Vector stretch = plant.position() - Kinematics::centre();
      return plant.energy(hand).kinetic + 0.5 * impedance.stiffness * stretch.squaredNorm();
    };
    double before = stored();
    const double first = before;
    for (int n = 0; n < 1500; ++n) {
      plant.advance(1e-3, motors, hand);
      CHECK(stored() <= before + 1e-13);
      before = stored();
    }
    // Friction holds up to 0.2 N against the spring.
    {
      CHECK(before <= 0.5 * 0.2 * 0.2 / impedance.stiffness);
      CHECK(before < 0.1 * first);
    }
  }
}

TEST("losses never run backward") {
  Plant plant;
  Motors motors;
  plant.place(Kinematics::centre(), nobody);
  double friction = 0.0;
  double stops = 0.0;
  for (int n = 0; n < 2000; ++n) {
    motors.command_torque(Vector::Constant(0.4 * std::sin(0.02 * n)));
    plant.advance(1e-3, motors, nobody);
    const EnergyAudit energy = plant.energy(nobody);
    CHECK(energy.friction_loss >= friction - 1e-15);
    CHECK(energy.stop_loss >= stops - 1e-15);
    friction = energy.friction_loss;
    stops = energy.stop_loss;
  }
  CHECK(friction > 0.0);
  CHECK(stops > 0.0);
}

Hand resting_hand() {
  Hand hand;
  hand.intent = Intent();
  return hand;
}

TEST("the person homes the device when the host asks, and only then") {
  PlantBody body({.homed = false, .homes = true, .seed = 3}, resting_hand());
  const auto homed = [&] {
    const DevicePacket packet = body.present();
    return packet.homed[0] && packet.homed[1] && packet.homed[2];
  };
  for (int step = 0; step < 20000; ++step) { body.advance(50e-6, {}, false); }
  CHECK(!homed());
  for (int step = 0; step < 50000; ++step) { body.advance(50e-6, {}, true); }
  CHECK(homed());
  const Kinematics kinematics;
  const auto angles = kinematics.inverse(body.plant().position());
  REQUIRE(angles);
  CHECK(body.present().counts == counts_of_angles(kinematics.geometry(), angles->theta1));
  body.lose_power();
  CHECK(!homed());
}

TEST("a word pulls the grip in, and the delivered force says so") {
  PlantBody body({}, resting_hand());
  const double before = body.plant().position().z();
  for (int step = 0; step < 20000; ++step) { body.advance(50e-6, {500, 500, 500}, false); }
  CHECK(body.plant().position().z() < before - 1e-3);
  CHECK(body.delivered_force().z() < -1.0);
}

TEST("what is asked for in newtons is what the hand gets") {
  EmulatedFalcon device({}, resting_hand());
  const Eigen::Vector3d force(0.5, -0.3, -1.2);
  double time = 0.0;
  for (int tick = 0; tick < 2000; ++tick) {
    device.exchange(force);
    device.run_until(time += 1e-3);
  }
  // A word is 0.0026 N of each motor at the centre; a count moves the pose by 0.05 mm.
  CHECK_NEAR(device.body().delivered_force(), force, 0.012);
  CHECK(!device.saturated());
  CHECK(device.counts().replies == 2000);
}

TEST("past the wire nothing is rounded, and two runs are the same to the bit") {
  Eigen::Vector3d ends[2];
  for (Eigen::Vector3d& end : ends) {
    EmulatedFalcon device({.wire = false}, resting_hand());
    for (int tick = 1; tick <= 500; ++tick) {
      const DeviceSample sample = device.exchange({0.1, 0.0, -0.4});
      CHECK(sample.position == device.body().plant().position());
      device.run_until(1e-3 * tick);
    }
    end = device.body().plant().position();
  }
  CHECK(ends[0] == ends[1]);
}

TEST("a start beyond reach is refused") {
  CHECK_THROWS(PlantBody({.start = {0.0, 0.0, 0.3}}, resting_hand()), "reach");
}

}  // namespace
