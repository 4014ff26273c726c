// SPDX-License-Identifier: MIT
#include "device/falcon/scripted_grip.hpp"

#include "tests/check.hpp"

namespace {

using namespace palpate::device::falcon;

constexpr double step = 1e-3;

void run(ScriptedGrip& grip, int ticks, bool homing) {
  for (int n = 0; n < ticks; ++n) { grip.advance(step, {}, homing); }
}

/// Out to 800 counts within 1 s, in to -100 within another.
GripScript out_and_in() {
  return {.poses = {{0.0, {0, 0, 0}}, {1.0, {800, 800, 600}}, {2.0, {-100, -100, -100}}},
          .power_on = {5000, -40000, 123},
          .homed = false};
}

TEST("counts go straight from pose to pose and rest outside") {
  ScriptedGrip grip({.poses = {{0.1, {100, 0, 0}}, {0.2, {-100, 0, 10}}}});
  CHECK(grip.present().counts[0] == 100);
  run(grip, 150, false);
  CHECK_NEAR(grip.present().counts[0], 0.0, 1.0);  // rounding of a count
  CHECK_NEAR(grip.present().counts[2], 5.0, 1.0);
  run(grip, 500, false);
  CHECK(grip.present().counts[0] == -100);
}

TEST("legs that go out beyond 60 degrees and back through the mark become homed") {
  ScriptedGrip grip(out_and_in());
  CHECK(grip.present().counts[0] == 5000);
  CHECK(grip.present().counts[1] == static_cast<std::int16_t>(-40000));  // wrapped
  run(grip, 2100, true);
  CHECK((grip.present().homed == std::array{true, true, false}));  // leg 3 stayed below 686
  CHECK(grip.present().counts[0] == -100);
  CHECK(grip.present().counts[2] == -100 + 123);
}

TEST("without the homing bit, or with it off on the way, nothing is homed") {
  ScriptedGrip never(out_and_in());
  run(never, 2100, false);
  CHECK((never.present().homed == std::array{false, false, false}));
  ScriptedGrip interrupted(out_and_in());
  run(interrupted, 1100, true);
  run(interrupted, 100, false);
  run(interrupted, 900, true);
  CHECK((interrupted.present().homed == std::array{false, false, false}));
}

TEST("power loss forgets homing") {
  ScriptedGrip grip({});
  CHECK((grip.present().homed == std::array{true, true, true}));
  grip.lose_power();
  CHECK((grip.present().homed == std::array{false, false, false}));
}

TEST("buttons are pressed in their time") {
  ScriptedGrip grip(
      {.presses = {{{.plus = true}, 0.0105, 0.0205}, {{.minus = true}, 0.0155, 1.0}}});
  CHECK((grip.present().buttons == Buttons{}));
  run(grip, 12, false);
  CHECK((grip.present().buttons == Buttons{.plus = true}));
  run(grip, 6, false);
  CHECK((grip.present().buttons == Buttons{.plus = true, .minus = true}));
  run(grip, 6, false);
  CHECK((grip.present().buttons == Buttons{.minus = true}));
}

}  // namespace
