// SPDX-License-Identifier: MIT
#include "device/falcon/encoders.hpp"

#include <numbers>

#include "tests/check.hpp"

namespace {

using namespace palpate::device::falcon;

const Geometry geometry = libnifalcon();
constexpr double degree = std::numbers::pi / 180.0;

Eigen::Vector3d all(double degrees) { return Eigen::Vector3d::Constant(degrees * degree); }

TEST("counts are rounded to the nearest by default, and down when asked") {
  const double count = 1.0 / geometry.counts_per_radian();
  const auto at = [&](double counts, Rounding rounding) {
    return counts_of_angle(geometry, geometry.zero_angle + counts * count, rounding);
  };
  CHECK(at(7.4, Rounding::nearest) == 7 && at(7.6, Rounding::nearest) == 8);
  CHECK(at(-7.4, Rounding::nearest) == -7 && at(-7.6, Rounding::nearest) == -8);
  CHECK(at(7.6, Rounding::floor) == 7 && at(-7.4, Rounding::floor) == -8);
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
  CHECK(wrapped(32767) == 32767 && wrapped(32768) == -32768 && wrapped(-32769) == 32767);
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
  CHECK(std::abs(offset) <= 2000 && !one.all_homed());
}

/// Out to `far` degrees and straight in to 20.
void pull_and_push(Encoders& encoders, double far, bool out_homing, bool in_homing) {
  for (double angle = 30.0; angle <= far; angle += 0.5) { encoders.sample(all(angle), out_homing); }
  for (double angle = far; angle >= 20.0; angle -= 0.5) { encoders.sample(all(angle), in_homing); }
}

TEST("pulled out and pushed in under the homing bit, all legs find their zero") {
  Encoders encoders(geometry, {}, 3);
  pull_and_push(encoders, 80.0, true, true);
  CHECK(encoders.all_homed());
  CHECK(encoders.counts() == counts_of_angles(geometry, all(20.0)));
}

TEST("homing needs the bit all the way, the pull beyond 60 degrees and the push") {
  for (const auto& [far, out, in] :
       {std::tuple{80.0, false, false}, std::tuple{80.0, true, false},
        std::tuple{80.0, false, false}, std::tuple{59.0, true, true}}) {
    Encoders encoders(geometry, {}, 3);
    pull_and_push(encoders, far, out, in);
    CHECK(!encoders.homed()[0] && !encoders.homed()[1] && !encoders.homed()[2]);
  }
  Encoders outward(geometry, {}, 3);
  for (double angle = 30.0; angle <= 80.0; angle += 0.5) { outward.sample(all(angle), true); }
  CHECK(!outward.all_homed());
}

TEST("each leg is homed on its own") {
  Encoders encoders(geometry, {}, 4);
  encoders.sample({70 * degree, 50 * degree, 70 * degree}, true);
  encoders.sample({30 * degree, 30 * degree, 36 * degree}, true);
  CHECK(encoders.homed()[0] && !encoders.homed()[1] && !encoders.homed()[2]);
  encoders.sample({30 * degree, 30 * degree, 34 * degree}, true);
  CHECK(encoders.homed()[2] && !encoders.all_homed());
}

}  // namespace
