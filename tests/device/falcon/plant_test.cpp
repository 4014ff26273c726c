// SPDX-License-Identifier: MIT

#include "device/falcon/plant.hpp"

#include <Eigen/LU>

#include "device/falcon/emulated_falcon.hpp"
#include "device/seeded.hpp"
#include "tests/check.hpp"

namespace PALPATE_FILE {

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

TEST("friction of sliding arms is the limit against their motion") {
  palpate::device::Seeded seeded(1);
  const ArmDynamics arms = random_arms(seeded, 10.0);
  CHECK_NEAR(friction_torque(arms, {1, -1, 1}, limit), Eigen::Vector3d(-limit, limit, -limit), 0.0);
}

TEST("friction of stuck arms cancels their acceleration") {
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

TEST("arms at rest always have one lawful state, stuck, sliding or mixed") {
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

TEST("moving arms keep their state") {
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
const Hand nobody{.impedance = no_hand};

/// Plant with its motors and a hand.
struct Rig {
  explicit Rig(const PlantOptions& options = {}, const Hand& held = nobody,
               const MotorOptions& of_motors = {})
      : plant(Kinematics(), options), motors(of_motors), hand(held) {}
  /// Advances by ticks of 1 ms.
  void run(int ticks) {
    for (int n = 0; n < ticks; ++n) { plant.advance(1e-3, motors, hand); }
  }
  void apply_force(const Vector& force) {
    motors.command_torque(torque_of_force(*Kinematics().jacobian(plant.position()), force));
  }
  EnergyAudit energy() { return plant.energy(hand); }

  Plant plant;
  Motors motors;
  Hand hand;
};

/// Final state after one second with a firm hand and changing torques.
Vector second(double substep, const std::vector<Action>& actions, double tremor) {
  PlantOptions options;
  if (substep > 0.0) { options.substep = substep; }
  Rig rig(options, {.impedance = firm_hand,
                    .intent = Intent({.start = grip_start,
                                      .direction = {0.1, 0.05, -1.0},
                                      .actions = actions,
                                      .tremor = tremor})});
  rig.plant.place(grip_start, rig.hand);
  for (int n = 0; n < 1000; ++n) {
    const double wave = 0.02 * std::sin(0.01 * n);
    rig.motors.command_torque({0.1 * wave - 0.01, 0.01, wave - 0.02});
    rig.run(1);
  }
  return rig.plant.position();
}

TEST("the plant converges at order four, through sticking and reversals too, to the same bits") {
  const std::vector<Action> smooth{Advance{0.03, 0.02, 0.2}};
  const std::vector<Action> reversing{Advance{0.02, 0.08, 0.1}, Withdraw{0.015, 0.08, 0.1}};
  for (const auto& [actions, tremor] : {std::pair{smooth, 0.0}, std::pair{reversing, 5e-5}}) {
    const Vector exact = second(12.5e-6, actions, tremor);
    const double coarse = (second(5e-4, actions, tremor) - exact).norm();
    const double fine = (second(2.5e-4, actions, tremor) - exact).norm();
    const Vector chosen = second(0.0, actions, tremor);  // the default substep
    CHECK_NEAR(std::log2(coarse / fine), 4.0, 0.2);
    CHECK((chosen - exact).norm() < 1e-9);
    CHECK(second(0.0, actions, tremor) == chosen);
  }
}

TEST("below Coulomb friction the device rests to the bit, just above it moves") {
  for (const double share : {0.99, 1.01}) {
    Rig rig({.gravity = 0.0});
    rig.plant.place(grip_start, nobody);
    rig.motors.command_torque(Vector::Constant(share * 4e-3));
    rig.run(2000);
    CHECK((rig.plant.position() == grip_start) == (share < 1.0));
    if (share > 1.0) { CHECK(rig.plant.position().z() > grip_start.z() + 1e-3); }
  }
}

TEST("a moving device that is left alone comes to rest and stays there to the bit") {
  Rig rig({.gravity = 0.0});
  rig.plant.place(Kinematics::centre(), nobody, {0.05, -0.08, 0.06});
  rig.run(1000);
  const Vector there = rig.plant.position();
  CHECK(rig.plant.velocity() == Vector::Zero());
  rig.run(1000);
  CHECK(rig.plant.position() == there);
}

TEST("a medium hand holds the device without drift") {
  Rig rig({}, {.intent = Intent({.start = grip_start})});
  rig.plant.place(grip_start + Vector(0.002, 0.001, -0.003), rig.hand);
  rig.run(3000);
  const Vector there = rig.plant.position();
  // Gravity displaces it by m g / k; friction limits the deviation to its force, 0.2 N, over k.
  CHECK_NEAR(there, grip_start - Vector(0.0, 0.13 * 9.80665 / 400.0, 0.0), 0.2 / 400.0);
  rig.run(3000);
  CHECK(rig.plant.position() == there);
}

TEST("arm inertia at the centre is that of the mechanism: 172 and 523 per m^2") {
  const Eigen::Matrix3d slope = inverse_jacobian(*Kinematics().legs(Kinematics::centre()));
  const Eigen::Matrix3d added = slope.transpose() * slope;
  CHECK_NEAR(added.diagonal(), Vector(172.0, 172.0, 523.0), 3.0);
  // A force then accelerates the mass and the arms.
  Rig rig(bare, nobody, {.time_constant = 0.0});
  for (int axis = 0; axis < 3; ++axis) {
    rig.plant.place(Kinematics::centre(), nobody);
    rig.apply_force(Vector::Unit(axis));
    rig.plant.advance(1e-4, rig.motors, nobody);
    const double mass = 0.13 + 4e-4 * added(axis, axis);
    // The force turns by 1e-9 on the way.
    CHECK_NEAR(rig.plant.velocity()[axis], 1e-4 / mass, 1e-9);
  }
}

TEST("without arms and friction the grip falls freely; a hand's mass is carried, a tool's weighs") {
  PlantOptions options = bare;
  options.arm_inertia = 0.0;
  options.gravity = 9.80665;
  Rig rig(options);
  rig.plant.place({0.0, 0.02, 0.125}, nobody);
  rig.run(80);
  CHECK_NEAR(rig.plant.position().y(), 0.02 - 0.5 * 9.80665 * 0.0064, 1e-14);
  options.gravity = 10.0;
  options.tool_mass = 0.07;
  Rig held(options, {.impedance = {.mass = 0.2, .viscosity = 0.0, .stiffness = 0.0}});
  held.plant.place({0.0, 0.02, 0.125}, held.hand);
  held.run(50);
  CHECK_NEAR(held.plant.velocity().y(), -0.05 * 10.0 * (0.13 + 0.07) / (0.13 + 0.07 + 0.2), 1e-13);
}

TEST("full torque ends at the stops, strained as their stiffness says") {
  for (const double direction : {1.0, -1.0}) {
    Rig rig({.gravity = 0.0, .elbow_stop = 0.0});
    rig.plant.place(Kinematics::centre(), nobody);
    rig.motors.command_torque(Vector::Constant(direction * 0.3));
    rig.run(3000);
    const PlantOptions& options = rig.plant.mechanics().options();
    const double stop = direction > 0.0 ? options.outer_stop : options.inner_stop;
    const double strain = 0.3 / options.stop_stiffness;
    const double slack = options.coulomb / options.stop_stiffness;
    CHECK_NEAR(rig.plant.theta1(), Vector::Constant(stop + direction * strain), 1.01 * slack);
    CHECK(rig.plant.halts() == 0);
  }
}

TEST("no motor command drives the mechanism out of its reach") {
  Rig rig;
  Seeded seeded(9);
  for (int n = 0; n < 5000; ++n) {
    if (n % 100 == 0) {
      Vector torque;
      for (double& each : torque) { each = seeded.uniform(-1.0, 1.0) > 0.0 ? 0.619 : -0.619; }
      rig.motors.command_torque(torque);
    }
    rig.run(1);
    CHECK(rig.plant.mechanics().kinematics().legs(rig.plant.position()).has_value());
  }
  CHECK(rig.plant.halts() <= 10);  // of 100,000 substeps with full torque either way
}

TEST("with an arm behind it the hand gives way further") {
  for (const bool arm : {false, true}) {
    Rig rig({}, {.intent = Intent({.start = grip_start})});
    if (arm) { rig.hand.arm = arm_stage; }
    rig.plant.place(grip_start, rig.hand);
    rig.apply_force({0.0, 0.0, 1.0});
    rig.run(4000);
    // 1 N over 400 N/m, and over 135 N/m in series; Coulomb friction of up to 0.2 N reduces it.
    const double expected = 1.0 / 400.0 + (arm ? 1.0 / 135.0 : 0.0);
    CHECK_NEAR(rig.plant.position().z() - grip_start.z(), expected, 0.3 * expected);
  }
}

TEST("a place beyond reach is refused and changes nothing") {
  Plant plant;
  const Vector before = plant.position();
  CHECK(!plant.place({0.0, 0.0, 0.4}, Hand{}));
  CHECK(plant.position() == before);
}

TEST("without friction and motors the energy is conserved while the arms swing") {
  // Heavy arms on a light grip, so that the velocity-dependent term dominates; only a spring
  // reverses the motion.
  const double stiffness = 200.0;
  Rig rig({.effector_mass = 0.02, .arm_inertia = 2e-3, .coulomb = 0.0, .viscosity = 0.0},
          {.impedance = {.mass = 0.0, .viscosity = 0.0, .stiffness = stiffness}});
  rig.plant.place({0.02, 0.015, 0.145}, rig.hand);
  const auto stored = [&] {
    const Vector stretch = rig.plant.position() - Kinematics::centre();
    return rig.energy().kinetic + rig.energy().potential + 0.5 * stiffness * stretch.squaredNorm();
  };
  const double first = stored();
  double fastest = 0.0;
  for (int n = 0; n < 2000; ++n) {
    rig.run(1);
    // Order four: (omega h)^4 / 120 a radian, omega some 50/s, h = 50 us. A hundredth of the term:
    // 3e-3.
    CHECK_NEAR(stored() / first, 1.0, 1e-11);
    fastest = std::max(fastest, rig.plant.velocity().norm());
  }
  CHECK(fastest > 0.3);
  CHECK(rig.energy().stop_loss == 0.0);
}

TEST("every joule is accounted for: motors, hand, weight, friction and stops") {
  for (const bool stops : {false, true}) {
    const std::vector<Action> actions{Advance{0.03, 0.05, 0.1}, Withdraw{0.03, 0.05, 0.1}};
    Rig rig({},
            {.impedance = firm_hand, .intent = Intent({.start = grip_start, .actions = actions})});
    rig.plant.place(grip_start, rig.hand);
    for (int n = 0; n < 1500; ++n) {
      const double push = stops && n > 500 ? 0.5 : 0.0;
      rig.motors.command_torque({push - 0.01, push + 0.02 * std::sin(0.05 * n), push});
      rig.run(1);
    }
    const EnergyAudit energy = rig.energy();
    CHECK(energy.friction_loss > 1e-4);
    CHECK(std::abs(energy.motor_work) > 1e-5);
    CHECK(stops == (energy.stop_loss > 1e-6));
    // Order four, except for the step with contact at a stop: there the damper force jumps, by 1e-4
    // of its later value.
    CHECK_NEAR(energy.imbalance(), 0.0, stops ? 1e-4 * energy.stop_loss : 1e-11);
  }
}

TEST("with commands of zero the device is passive") {
  Rig rig;
  rig.plant.place({0.0, 0.02, 0.13}, nobody, {0.2, 0.1, -0.3});
  double before = rig.energy().kinetic + rig.energy().potential;
  for (int n = 0; n < 3000; ++n) {
    rig.run(1);
    CHECK(rig.energy().motor_work == 0.0);
    const double now = rig.energy().kinetic + rig.energy().potential;
    CHECK(now <= before + 1e-9);  // the integrator's share at the stops
    before = now;
  }
}

TEST("without input the energy decays in every grip") {
  for (const HandImpedance& impedance : {light_hand, medium_hand, firm_hand}) {
    Rig rig({.gravity = 0.0}, {.impedance = impedance});
    rig.plant.place({0.01, 0.01, 0.135}, rig.hand);
    const auto stored = [&] {
      const Vector stretch = rig.plant.position() - Kinematics::centre();
      return rig.energy().kinetic + 0.5 * impedance.stiffness * stretch.squaredNorm();
    };
    double before = stored();
    const double first = before;
    for (int n = 0; n < 1500; ++n) {
      rig.run(1);
      CHECK(stored() <= before + 1e-13);
      before = stored();
    }
    CHECK(before <= 0.5 * 0.2 * 0.2 / impedance.stiffness);  // friction holds up to 0.2 N
    CHECK(before < 0.1 * first);
  }
}

TEST("losses never run backward") {
  Rig rig;
  rig.plant.place(Kinematics::centre(), nobody);
  EnergyAudit before{};
  for (int n = 0; n < 2000; ++n) {
    rig.motors.command_torque(Vector::Constant(0.4 * std::sin(0.02 * n)));
    rig.run(1);
    const EnergyAudit energy = rig.energy();
    CHECK(energy.friction_loss >= before.friction_loss - 1e-15);
    CHECK(energy.stop_loss >= before.stop_loss - 1e-15);
    before = energy;
  }
  CHECK(before.friction_loss > 0.0);
  CHECK(before.stop_loss > 0.0);
}

const Hand resting_hand{.intent = Intent()};

TEST("the person homes the device when the host asks, and only then") {
  PlantBody body({.homed = false, .homes = true, .seed = 3}, resting_hand);
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

TEST("a motor word pulls the grip inwards, and the delivered force has that sign") {
  PlantBody body({}, resting_hand);
  const double before = body.plant().position().z();
  for (int step = 0; step < 20000; ++step) { body.advance(50e-6, {500, 500, 500}, false); }
  CHECK(body.plant().position().z() < before - 1e-3);
  CHECK(body.delivered_force().z() < -1.0);
}

TEST("the hand receives the force commanded in newtons") {
  EmulatedFalcon device({}, resting_hand);
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
    EmulatedFalcon device({.wire = false}, resting_hand);
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
  CHECK_THROWS(PlantBody({.start = {0.0, 0.0, 0.3}}, resting_hand), "reach");
}

}  // namespace PALPATE_FILE
