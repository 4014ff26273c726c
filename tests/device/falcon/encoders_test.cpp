// SPDX-License-Identifier: MIT

#include <numbers>

#include "device/falcon/body.hpp"
#include "device/falcon/motors_encoders.hpp"
#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate::device::falcon;

const Geometry geometry = libnifalcon();
constexpr double degree = std::numbers::pi / 180.0;

Eigen::Vector3d all(double degrees) { return Eigen::Vector3d::Constant(degrees * degree); }

TEST("counts are rounded to the nearest") {
  const double count = 1.0 / geometry.counts_per_radian();
  const auto at = [&](double counts) {
    return counts_of_angle(geometry, geometry.zero_angle + counts * count);
  };
  CHECK(at(7.4) == 7);
  CHECK(at(7.6) == 8);
  CHECK(at(-7.4) == -7);
  CHECK(at(-7.6) == -8);
}

TEST("angles of counts are exact at every count and grow outward") {
  for (int n = -1600; n <= 1600; n += 7) {
    const auto count = static_cast<std::int16_t>(n);
    const Eigen::Vector3d theta1 = angles_of_counts(geometry, {count, count, count});
    CHECK(counts_of_angles(geometry, theta1)[1] == count);
    CHECK_NEAR((theta1[0] - 35.0 * degree) / degree, n * 360.0 * 14.25 / (1280.0 * 110.0), 1e-12);
  }
}

TEST("a counter is sixteen bits wide") {
  CHECK(wrapped(32767) == 32767);
  CHECK(wrapped(32768) == -32768);
  CHECK(wrapped(-32769) == 32767);
  CHECK(wrapped(-38982) == 26554);  // the published wrap of a word
}

TEST("after power-on the counts are off by a constant that the seed decides") {
  Encoders one(geometry, {}, 1), same(geometry, {}, 1), other(geometry, {}, 2);
  const Counts truth = counts_of_angles(geometry, all(30.0));
  for (Encoders* each : {&one, &same, &other}) { each->sample(all(30.0), false); }
  CHECK(one.counts() == same.counts());
  CHECK(one.counts() != other.counts());
  const int offset = one.counts()[0] - truth[0];
  one.sample(all(50.0), false);
  CHECK(one.counts()[0] - counts_of_angles(geometry, all(50.0))[0] == offset);
  CHECK(std::abs(offset) <= 2000);
  CHECK(!one.all_homed());
}

/// Moves out to `far` degrees and in to 20 degrees.
void pull_and_push(Encoders& encoders, double far, bool out_homing, bool in_homing) {
  for (double angle = 30.0; angle <= far; angle += 0.5) { encoders.sample(all(angle), out_homing); }
  for (double angle = far; angle >= 20.0; angle -= 0.5) { encoders.sample(all(angle), in_homing); }
}

TEST("homing needs the bit all the way, the pull beyond 60 degrees and the push") {
  for (const auto& [far, out, in] : {std::tuple{80.0, true, true},
                                     {80.0, false, false},
                                     {80.0, true, false},
                                     {59.0, true, true}}) {
    Encoders encoders(geometry, {}, 3);
    pull_and_push(encoders, far, out, in);
    const bool homed = far > 60.0 && out && in;
    for (const bool leg : encoders.homed()) { CHECK(leg == homed); }
    CHECK((encoders.counts() == counts_of_angles(geometry, all(20.0))) == homed);
  }
  Encoders outward(geometry, {}, 3);
  for (double angle = 30.0; angle <= 80.0; angle += 0.5) { outward.sample(all(angle), true); }
  CHECK(!outward.all_homed());
}

TEST("each leg is homed on its own") {
  Encoders encoders(geometry, {}, 4);
  encoders.sample({70 * degree, 50 * degree, 70 * degree}, true);
  encoders.sample({30 * degree, 30 * degree, 36 * degree}, true);
  CHECK(encoders.homed()[0]);
  CHECK(!encoders.homed()[1]);
  CHECK(!encoders.homed()[2]);
  encoders.sample({30 * degree, 30 * degree, 34 * degree}, true);
  CHECK(encoders.homed()[2]);
  CHECK(!encoders.all_homed());
}

/// Advances by ticks of 1 ms.
void run(ScriptedGrip& grip, int ticks, bool homing) {
  for (int n = 0; n < ticks; ++n) { grip.advance(1e-3, {}, homing); }
}

/// Moves out to 800 counts within 1 s, then in to -100 counts within another second.
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

TEST("without the homing bit, or with it off on the way, nothing is homed; power loss forgets it") {
  ScriptedGrip never(out_and_in());
  run(never, 2100, false);
  CHECK((never.present().homed == std::array{false, false, false}));
  ScriptedGrip interrupted(out_and_in());
  run(interrupted, 1100, true);
  run(interrupted, 100, false);
  run(interrupted, 900, true);
  CHECK((interrupted.present().homed == std::array{false, false, false}));
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

}  // namespace PALPATE_FILE
