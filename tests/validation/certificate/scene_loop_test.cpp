// SPDX-License-Identifier: MIT
#include "validation/certificate/scene_loop.hpp"

#include "tests/check.hpp"
#include "tests/model/tool_scenes.hpp"
#include "validation/rollout.hpp"

namespace {

using namespace palpate;
using namespace palpate::certificate;

Scene needle_scene() {
  Scene scene = layered_scene();
  scene.drive->speed = 0.04;
  scene.simulation = {.duration = 0.4, .step = 1e-3};
  return scene;
}

Scene hand_scene(double step) {
  Scene scene = layered_scene();
  scene.drive = Drive{.kind = Drive::Kind::falcon, .speed = 0.02};
  scene.simulation = {.duration = 0.2, .step = step};
  return scene;
}

TEST("it steps what a run steps: the same state after the same ticks, and the same events") {
  const Scene scene = needle_scene();
  Simulation simulation(scene);
  const Run run = roll_out(simulation, {});
  SceneLoop loop(scene, 1000.0);
  std::size_t events = 0;
  while (!loop.over()) {
    CHECK(loop.tick() == StepStatus::ok);
    events += loop.happenings().size();
  }
  Eigen::VectorXd a(simulation.problem().dof());
  Eigen::VectorXd b(a.size());
  simulation.coordinates(a);
  loop.simulation().coordinates(b);
  CHECK(a == b);
  CHECK(events == run.trace.events.size() && events >= 2);
}

TEST("a hand on a slower tissue: device ticks in between, the same end as a run") {
  for (const double step : {1e-3, 4e-3}) {
    const Scene scene = hand_scene(step);
    Simulation simulation(scene);
    FalconLoop falcon(scene, simulation);
    const Run run = roll_out(simulation, {.falcon = &falcon});
    SceneLoop loop(scene, 1000.0);
    CHECK(loop.tick_count() == 200);
    long ticks = 0;
    for (; !loop.over(); ++ticks) { (void)loop.tick(); }
    CHECK(ticks == 200);
    CHECK(loop.falcon()->facts().ticks == run.falcon->ticks);
    CHECK_NEAR(loop.falcon()->facts().least_energy, run.falcon->least_energy, 0.0);
    CHECK_NEAR(loop.simulation().tool_motion().place, simulation.tool_motion().place, 0.0);
  }
}

TEST("without a device nothing is computed between two steps") {
  Scene scene = needle_scene();
  SceneLoop loop(scene, 5000.0);
  for (int n = 0; n < 10; ++n) { (void)loop.tick(); }
  CHECK(loop.simulation().ticks() == 2);
  CHECK(loop.tick_count() == 2000);
}

TEST("a syringe sends 120 frames a second, and all are read") {
  Scene scene = needle_scene();
  scene.syringe = Syringe{};
  SceneLoop loop(scene, 1000.0);
  while (!loop.over()) { (void)loop.tick(); }
  CHECK(loop.pressure_line()->counts().frames == 49);  // at 0, 1/120, ... 48/120 s
  CHECK(loop.pressure_line()->counts().bad_frames == 0);
}

TEST("faults damage every other frame, and the reader finds the rest") {
  Scene scene = needle_scene();
  scene.syringe = Syringe{};
  SceneLoop loop(scene, 1000.0, {.faults = true});
  while (!loop.over()) { (void)loop.tick(); }
  CHECK(loop.pressure_line()->counts().frames == 25);
  CHECK(loop.pressure_line()->counts().bad_frames >= 23);
}

TEST("a step must be a whole number of periods, and a haptic loop keeps its own rate") {
  const Scene scene = needle_scene();
  CHECK(why_not_at(scene, 1000.0).empty() && why_not_at(scene, 3000.0).empty());
  CHECK(why_not_at(scene, 500.0).find("a rate of 1000 Hz or a whole multiple") != std::string::npos);
  CHECK(!why_not_at(scene, 1500.0).empty());
  CHECK(why_not_at(hand_scene(1e-3), 2000.0).find("falcon.rate") != std::string::npos);
  CHECK_NEAR(rate_of(scene), 1000.0, 1e-9);
  CHECK_NEAR(rate_of(hand_scene(4e-3)), 1000.0, 0.0);
}

TEST("happenings have the name of what the needle was in") {
  const Scene scene = needle_scene();
  const HappeningNames names(scene);
  CHECK(names.of({.event = ToolEvent::puncture, .interval = 0}) == "puncture: skin");
}

}  // namespace
