// SPDX-License-Identifier: MIT
#include "validation/falcon_loop.hpp"

#include <algorithm>

#include "tests/check.hpp"
#include "validation/cases/tool_setting.hpp"
#include "validation/rollout.hpp"

using namespace palpate;

namespace {

Scene held_scene() {
  Scene scene = tools::seven_soft_layers(0.006, 4);
  scene.drive = Drive{.kind = Drive::Kind::falcon, .from = -0.002, .speed = 0.03};
  scene.falcon = FalconDrive{.hand = FalconDrive::Hand::firm, .seed = 5};
  scene.simulation = {.duration = 1.2, .step = 1e-3};
  return scene;
}

struct Held {
  Run run{};
  FalconFacts facts{};
};

Held hold(const Scene& scene, int extra_delay = 0) {
  Simulation simulation(scene);
  FalconLoop loop(scene, simulation, extra_delay);
  Held held;
  held.run = roll_out(simulation, {.falcon = &loop});
  held.facts = loop.facts();
  return held;
}

}  // namespace

TEST("the tool follows the hand through the layers, and the hand feels them") {
  const Held held = hold(held_scene());
  CHECK(!held.run.diverged);
  CHECK(held.facts.lost_resistance_at.has_value());
  CHECK(held.facts.ticks == 1200);
  CHECK(held.facts.unanswered == 0);
  CHECK(held.facts.largest_requested > 1.0);
  // The motors lag by half a millisecond and words are whole: never more than was asked for, but for
  // two words of each motor, 0.0026 N each, seen from the weakest direction.
  CHECK(held.facts.largest_delivered <= held.facts.largest_requested + 0.02);
}

TEST("two runs are the same to the bit") {
  const Held first = hold(held_scene());
  const Held second = hold(held_scene());
  CHECK(first.run.trace.columns.size() == second.run.trace.columns.size());
  for (std::size_t n = 0; n < first.run.trace.columns.size(); ++n) {
    CHECK(first.run.trace.columns[n].values == second.run.trace.columns[n].values);
  }
}

TEST("one tick of delay more shows in the force on the hand") {
  Scene scene = held_scene();
  scene.falcon->quantised = false;
  const auto first_force = [&](int extra) {
    const Trace trace = hold(scene, extra).run.trace;
    const std::vector<double>& force = trace.find("device.requested_n")->values;
    return std::ranges::find_if(force, [](double f) { return f > 0.0; }) - force.begin();
  };
  const auto prompt = first_force(0);
  CHECK(first_force(1) == prompt + 1);
  CHECK(first_force(3) == prompt + 3);
}

TEST("a quicker hand overshoots less") {
  Scene scene = held_scene();
  scene.falcon->reaction_delay = 0.0;
  const double quick = hold(scene).facts.overshoot;
  scene.falcon->reaction_delay = 0.15;
  const double slow = hold(scene).facts.overshoot;
  // The intent goes on at 30 mm/s for 0.15 s more; layers behind may take some of it up.
  CHECK(slow > quick + 0.5 * 0.03 * 0.15);
}

TEST("tissue that is slower than the loop is held or led on") {
  Scene scene = held_scene();
  scene.falcon->rate = 2000.0;
  CHECK(hold(scene).facts.ticks == 2400);
  scene.falcon->between = FalconDrive::Between::extrapolate;
  CHECK(!hold(scene).run.diverged);
}
