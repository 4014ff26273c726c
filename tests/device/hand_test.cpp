// SPDX-License-Identifier: MIT
#include "device/hand.hpp"

#include "tests/check.hpp"

namespace {

using namespace palpate::device;
using Vector = Eigen::Vector3d;

const IntentPoint intent{.position = {0.0, 0.0, 0.1}, .velocity = {0.0, 0.01, 0.0}};
const Vector grip(0.001, 0.0, 0.102);
const Vector velocity(0.0, 0.0, 0.03);

TEST("the presets are the documented ones, from light to firm") {
  CHECK(light_hand.mass == 0.10 && light_hand.viscosity == 3.0 && light_hand.stiffness == 150.0);
  CHECK(medium_hand.mass == 0.15 && medium_hand.viscosity == 6.0 && medium_hand.stiffness == 400.0);
  CHECK(firm_hand.mass == 0.25 && firm_hand.viscosity == 12.0 && firm_hand.stiffness == 1000.0);
  CHECK(arm_stage.mass == 0.55 && arm_stage.viscosity == 6.5 && arm_stage.stiffness == 135.0);
}

TEST("the hand pulls with its spring and its damper toward the intent") {
  const HandForces forces = hand_forces(Hand{}, intent, grip, velocity, {});
  CHECK_NEAR(forces.on_grip, Vector(-0.4, 0.06, -0.8 - 0.18), 1e-13);
  CHECK_NEAR(forces.on_arm, Vector::Zero(), 0.0);
}

TEST("a push replaces the spring along its axis and nothing else") {
  IntentPoint push = intent;
  push.pushing = true;
  push.push = 2.0;
  const HandForces forces = hand_forces(Hand{}, push, grip, velocity, {});
  CHECK_NEAR(forces.on_grip, Vector(-0.4, 0.06, -2.0 - 0.18), 1e-13);  // the axis is -z
}

TEST("with an arm, what the hand takes from the grip the arm feels") {
  const Hand hand{.arm = arm_stage};
  const ArmMotion arm{.position = {0.0, 0.0, 0.101}, .velocity = {0.02, 0.0, 0.0}};
  const HandForces forces = hand_forces(hand, intent, grip, velocity, arm);
  CHECK_NEAR(forces.on_grip, Vector(-0.4 + 0.12, 0.0, -0.4 - 0.18), 1e-13);
  const Vector toward_intent(-6.5 * 0.02, 6.5 * 0.01, -135.0 * 0.001);
  CHECK_NEAR(forces.on_grip + forces.on_arm, toward_intent, 1e-13);
}

TEST("nobody at the grip means no force and no mass") {
  const Hand hand{.impedance = no_hand};
  CHECK_NEAR(hand_forces(hand, intent, grip, velocity, {}).on_grip, Vector::Zero(), 0.0);
  CHECK(hand.impedance.mass == 0.0);
}

}  // namespace
