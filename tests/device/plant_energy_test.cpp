// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "device/falcon/plant.hpp"
#include "tests/check.hpp"

namespace {

using namespace palpate::device;
using namespace palpate::device::falcon;
using Vector = Eigen::Vector3d;

const Hand nobody{.impedance = no_hand};

TEST("without friction and motors the energy is conserved while the arms swing") {
  // Heavy arms on a light grip, so that the velocity-dependent term does most of the work; a
  // spring alone turns the motion back.
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
  CHECK(fastest > 0.3 && plant.energy(spring).stop_loss == 0.0);
  // Order four: (omega h)^4 / 120 a radian, omega some 50/s, h = 50 us. A hundredth of the term:
  // 3e-3.
  CHECK_NEAR(largest, 0.0, 1e-11);
  std::printf("  largest share of energy gained or lost %.2g at %.2g m/s\n", largest, fastest);
}

TEST("every joule is accounted for: motors, hand, weight, friction and stops") {
  for (const bool stops : {false, true}) {
    Plant plant;
    Motors motors;
    const Vector start(0.01, -0.005, 0.14);
    const Hand hand{
        .impedance = firm_hand,
        .intent = Intent(
            {.start = start, .actions = {Advance{0.03, 0.05, 0.1}, Withdraw{0.03, 0.05, 0.1}}})};
    plant.place(start, hand);
    for (int n = 0; n < 1500; ++n) {
      const double push = stops && n > 500 ? 0.5 : 0.0;
      motors.command_torque({push - 0.01, push + 0.02 * std::sin(0.05 * n), push});
      plant.advance(1e-3, motors, hand);
    }
    const EnergyAudit energy = plant.energy(hand);
    CHECK(energy.friction_loss > 1e-4 && std::abs(energy.motor_work) > 1e-5);
    CHECK(stops == (energy.stop_loss > 1e-6));
    // Order four, but for the step in which a stop is met: there its damper jumps, by 1e-4 of what
    // it then takes.
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
    // What friction holds: up to 0.2 N against the spring.
    CHECK(before <= 0.5 * 0.2 * 0.2 / impedance.stiffness && before < 0.1 * first);
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
    CHECK(energy.friction_loss >= friction - 1e-15 && energy.stop_loss >= stops - 1e-15);
    friction = energy.friction_loss;
    stops = energy.stop_loss;
  }
  CHECK(friction > 0.0 && stops > 0.0);
}

}  // namespace
