// SPDX-License-Identifier: MIT

#include "device/hand.hpp"

#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate::device;
using Vector = Eigen::Vector3d;

const Vector start(0.0, 0.0, 0.125);

/// Displacement along the axis [m].
double along(const Intent& intent, double time) {
  return (intent.at(time).position - start).dot(intent.direction());
}

TEST("without actions the intent rests at its start") {
  const Intent intent;
  CHECK_NEAR(intent.at(3.0).position, start, 0.0);
  CHECK_NEAR(intent.at(3.0).velocity, Vector::Zero(), 0.0);
}

TEST("velocity is the derivative of position through every action, tremor and stop") {
  Intent intent({.actions = {Hold{0.2}, Advance{0.02, 0.01, 0.2}, Intermittent{.distance = 0.006},
                             Withdraw{0.01, 0.02, 0.1}, Advance{0.001, 0.05, 0.4}},
                 .tremor = 5e-5,
                 .speed_variation = 0.1,
                 .seed = 7});
  for (const bool stopped : {false, true}) {
    if (stopped) { intent.loss_of_resistance(0.9); }
    const double h = 1e-5;
    for (double time = 0.013; time < intent.end() + 0.5; time += 0.0037) {
      const Vector difference =
          (intent.at(time + h).position - intent.at(time - h).position) / (2.0 * h);
      // h times a jump of the acceleration of 1 m/s^2, or h^2/6 of a jerk of some 1e3 m/s^3
      CHECK_NEAR(intent.at(time).velocity, difference, 1e-5);
    }
  }
}

TEST("a continuous advance keeps its speed between a smooth start and end") {
  const Intent intent({.actions = {Advance{0.02, 0.005, 0.2}}});
  CHECK_NEAR(intent.end(), 0.02 / 0.005 + 0.2, 1e-12);
  for (const double time : {0.2, 1.0, 3.9}) {
    CHECK_NEAR(intent.at(time).velocity, Vector(0.0, 0.0, -0.005), 1e-15);
  }
  CHECK_NEAR(along(intent, 0.0), 0.0, 0.0);
  CHECK_NEAR(along(intent, 10.0), 0.02, 1e-16);
  CHECK_NEAR(intent.at(10.0).velocity, Vector::Zero(), 0.0);
}

TEST("intermittent motion goes in steps of its range with rests of its range") {
  const Intent intent({.actions = {Intermittent{.distance = 0.02}}, .seed = 5});
  double stopped = 0.0;
  double from = 0.0;
  bool moved = false;
  int steps = 0;
  for (double time = 0.0; time < intent.end() + 1e-3; time += 1e-4) {
    const bool moving = intent.at(time).velocity.norm() > 1e-9;
    if (moving && !moved) {
      if (steps > 0) { CHECK_NEAR(time - stopped, 0.6595, 0.3605); }  // 0.3 to 1 s and a ramp
      from = along(intent, time);
    }
    if (!moving && moved) {
      stopped = time;
      if (along(intent, time) < 0.0199) { CHECK_NEAR(along(intent, time) - from, 2e-3, 1.01e-3); }
      ++steps;
    }
    moved = moving;
  }
  CHECK(steps >= 7);
  CHECK(steps <= 20);
  CHECK_NEAR(along(intent, intent.end()), 0.02, 1e-15);
}

TEST("a push rises at its rate, stays, and frees the spring along the axis") {
  const Intent intent({.actions = {Hold{1.0}, Push{.force = 4.0, .rise = 2.0, .duration = 5.0}}});
  CHECK(!intent.at(0.5).pushing);
  CHECK(intent.at(1.5).pushing);
  CHECK_NEAR(intent.at(2.0).push, 2.0, 1e-12);
  CHECK_NEAR(intent.at(9.0).push, 4.0, 1e-12);
}

TEST("after a loss of resistance the intent goes on for the reaction time, then stops smoothly") {
  IntentScript script{.actions = {Advance{0.05, 0.01, 0.2}}, .seed = 3};
  Intent intent(script);
  const Intent unaware(script);
  CHECK(intent.reaction() >= 0.15);
  CHECK(intent.reaction() <= 0.20);
  intent.loss_of_resistance(1.0);
  intent.loss_of_resistance(1.1);  // only the first counts
  const double stop = 1.0 + intent.reaction();
  CHECK_NEAR(along(intent, stop - 1e-9), along(unaware, stop - 1e-9), 0.0);
  // Overshoot of the law: speed times (reaction + half the braking).
  CHECK_NEAR(along(intent, 5.0) - along(unaware, 1.0), 0.01 * (intent.reaction() + 0.05), 1e-12);
  CHECK_NEAR(intent.at(stop + 0.1).velocity, Vector::Zero(), 0.0);
}

TEST("a push fades after the reaction time") {
  Intent intent({.actions = {Push{.force = 4.0, .rise = 1.0, .duration = 9.0}}});
  intent.loss_of_resistance(2.0);
  CHECK_NEAR(intent.at(2.0 + 0.99 * intent.reaction()).push, 4.0, 0.0);
  CHECK_NEAR(intent.at(2.3 + intent.reaction()).push, 0.0, 0.0);
}

TEST("a withdrawal that was planned follows the stop, then the new insertion") {
  Intent intent({.actions = {Advance{0.03, 0.01, 0.2}, Hold{5.0}, Withdraw{0.01, 0.01, 0.1},
                             Advance{0.005, 0.01, 0.1}}});
  intent.loss_of_resistance(1.0);
  const double stop = 1.0 + intent.reaction() + 0.1;
  const double deepest = along(intent, stop);
  CHECK_NEAR(along(intent, stop + 1.1), deepest - 0.01, 1e-12);  // 10 mm at 10 mm/s and 0.1 s ramp
  CHECK_NEAR(along(intent, intent.end() + 1.0), deepest - 0.005, 1e-12);
  intent.loss_of_resistance(stop + 0.5);
  CHECK_NEAR(along(intent, intent.end() + 1.0), deepest - 0.005, 1e-12);
}

TEST("tremor has its amplitude, its band and the seed's phases") {
  const Intent intent({.tremor = 5e-5, .seed = 11});
  double squares = 0.0;
  int crossings = 0;
  const int samples = 60000;
  double before = 0.0;
  for (int n = 0; n < samples; ++n) {
    const double x = intent.at(n * 1e-3).position.x();
    squares += x * x;
    crossings += before < 0.0 && x >= 0.0 ? 1 : 0;
    before = x;
  }
  CHECK_NEAR(std::sqrt(2.0 * squares / samples), 5e-5, 5e-6);  // five sines over a minute
  CHECK_NEAR(crossings, 10 * 60, 3 * 60 - 1);                  // 7 to 13 a second
  CHECK(Intent({.tremor = 5e-5, .seed = 11}).at(0.3).position == intent.at(0.3).position);
  CHECK(Intent({.tremor = 5e-5, .seed = 12}).at(0.3).position != intent.at(0.3).position);
}

TEST("scripts that make no sense are refused with their rule") {
  CHECK_THROWS(Intent({.direction = Vector::Zero()}), "direction");
  CHECK_THROWS(Intent({.actions = {Advance{.speed = 0.0}}}), "must be > 0");
  CHECK_THROWS(Intent({.actions = {Push{}, Withdraw{}}}), "last action");
  CHECK_THROWS(Intent({.actions = {Intermittent{.step = {2e-3, 1e-3}}}}), "ranges ordered");
}

const IntentPoint intent{.position = {0.0, 0.0, 0.1}, .velocity = {0.0, 0.01, 0.0}};
const Vector grip(0.001, 0.0, 0.102);
const Vector velocity(0.0, 0.0, 0.03);

TEST("the presets are the documented ones, from light to firm") {
  const auto values = [](const HandImpedance& hand) {
    return Vector(hand.mass, hand.viscosity, hand.stiffness);
  };
  CHECK_NEAR(values(light_hand), Vector(0.10, 3.0, 150.0), 0.0);
  CHECK_NEAR(values(medium_hand), Vector(0.15, 6.0, 400.0), 0.0);
  CHECK_NEAR(values(firm_hand), Vector(0.25, 12.0, 1000.0), 0.0);
  CHECK_NEAR(values(arm_stage), Vector(0.55, 6.5, 135.0), 0.0);
}

TEST("the hand pulls with its spring and its damper toward the intent") {
  const HandForces forces = hand_forces(Hand{}, intent, grip, velocity, {});
  CHECK_NEAR(forces.on_grip, Vector(-0.4, 0.06, -0.8 - 0.18), 1e-13);
  CHECK_NEAR(forces.on_arm, Vector::Zero(), 0.0);
  const Hand nobody{.impedance = no_hand};
  CHECK_NEAR(hand_forces(nobody, intent, grip, velocity, {}).on_grip, Vector::Zero(), 0.0);
  CHECK(no_hand.mass == 0.0);
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

}  // namespace PALPATE_FILE
