// SPDX-License-Identifier: MIT
#include "model/dynamics/drive_motion.hpp"

#include <cmath>

#include "tests/check.hpp"

namespace {

using namespace palpate;

TEST("a continuous trajectory goes on at its speed from the start") {
  const Trajectory path({.start = 0.1, .from = -0.001, .speed = 0.005}, 2.0);
  CHECK(path.place(0.0) == -0.001);
  CHECK(path.place(0.1) == -0.001);
  CHECK_NEAR(path.place(1.1), -0.001 + 0.005, 1e-15);
  CHECK_NEAR(path.place(2.0), -0.001 + 0.0095, 1e-15);
}

TEST("it ends at its depth, holds, and comes back to where it began") {
  const Trajectory path(
      {.from = -0.002, .speed = 0.01, .depth = 0.008, .hold = 0.5, .withdraw_speed = 0.02}, 10.0);
  CHECK_NEAR(path.place(1.0), 0.008, 1e-15);
  CHECK_NEAR(path.place(1.49), 0.008, 1e-15);
  CHECK_NEAR(path.place(1.6), 0.006, 1e-15);
  CHECK_NEAR(path.place(5.0), -0.002, 1e-15);
}

TEST("without a withdrawal it stays") {
  const Trajectory path({.speed = 0.01, .depth = 0.008}, 10.0);
  CHECK_NEAR(path.place(9.0), 0.008, 1e-15);
}

TEST("an intermittent trajectory advances, pauses, advances") {
  const Trajectory path({.technique = Drive::Technique::intermittent,
                         .speed = 0.01,
                         .advance = 0.002,
                         .pause = 0.3,
                         .depth = 0.005},
                        10.0);
  CHECK_NEAR(path.place(0.1), 0.001, 1e-15);
  CHECK_NEAR(path.place(0.4), 0.002, 1e-15);
  CHECK_NEAR(path.place(0.6), 0.003, 1e-15);
  CHECK_NEAR(path.place(0.9), 0.004, 1e-15);
  CHECK_NEAR(path.place(1.05), 0.0045, 1e-15);
  CHECK_NEAR(path.place(3.0), 0.005, 1e-15);
}

TEST("a speed of zero never moves the tool") {
  const Trajectory path({.from = 0.001, .speed = 0.0}, 1.0);
  CHECK(path.place(0.7) == 0.001);
}

TEST("the hand's force rises, holds and turns round") {
  const Drive drive{.start = 0.5, .hold = 1.0, .force = 4.0, .rise = 2.0, .withdraw_force = 1.5};
  CHECK(hand_force(drive, 0.4) == 0.0);
  CHECK_NEAR(hand_force(drive, 1.5), 2.0, 1e-15);
  CHECK(hand_force(drive, 3.0) == 4.0);
  CHECK(hand_force(drive, 4.0) == -1.5);
}

TEST("intermittent pushes come and go") {
  const Drive drive{.technique = Drive::Technique::intermittent,
                    .pause = 0.3,
                    .force = 4.0,
                    .rise = 0.0,
                    .push = 0.2};
  CHECK(hand_force(drive, 0.1) == 4.0);
  CHECK(hand_force(drive, 0.3) == 0.0);
  CHECK(hand_force(drive, 0.6) == 4.0);
}

}  // namespace
