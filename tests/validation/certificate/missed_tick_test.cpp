// SPDX-License-Identifier: MIT
#include "validation/certificate/missed_tick.hpp"

#include <cmath>

#include "tests/check.hpp"
#include "tests/model/tool_scenes.hpp"

namespace {

using namespace palpate;
using namespace palpate::certificate;

/// A hand presses a needle against layers that it never gets through.
Scene pressing(double coupling) {
  Scene scene = layered_scene();
  for (Material& each : scene.materials) { each.cutting_force = 50.0; }
  scene.drive = Drive{.kind = Drive::Kind::falcon, .speed = 0.02, .depth = 0.004};
  scene.falcon = FalconDrive{.coupling_stiffness = coupling, .quantised = false, .friction = false};
  scene.simulation = {.duration = 0.3, .step = 1e-3};
  return scene;
}

TEST("the bound is half of K (v T)^2, and twice that beside a loop that holds its forces anyway") {
  const MissedTick missed = bounded_missed_tick(2000.0, 0.1, 1e-3);
  CHECK_NEAR(missed.bound, 1e-5, 1e-20);  // (1e-4 m)^2 of 2000 N/m, halved
  CHECK_NEAR(missed.sampled_bound, 2e-5, 1e-20);
}

TEST("a tick that is missed gives the hand energy, of a smooth motion no more than its bound") {
  const MissedTick missed = measure_missed_tick(pressing(2000.0), nullptr);
  CHECK(missed.measured && *missed.measured > 0.0 && *missed.measured <= missed.sampled_bound);
  CHECK_NEAR(missed.stiffness, 2000.0, 0.0);
  CHECK(missed.speed > 0.01);
  CHECK_NEAR(missed.bound, 0.5 * 2000.0 * std::pow(1e-3 * missed.speed, 2), 1e-15);
}

TEST("the same scene gives the same energy") {
  const Scene scene = pressing(1000.0);
  CHECK_NEAR(*measure_missed_tick(scene, nullptr).measured, *measure_missed_tick(scene, nullptr).measured,
             0.0);
}

}  // namespace
