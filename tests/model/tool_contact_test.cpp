// SPDX-License-Identifier: MIT
#include "model/stepping/tool_contact.hpp"

#include <algorithm>
#include <cmath>

#include "model/dynamics/network_builder.hpp"
#include "model/stepping/simulation.hpp"
#include "tests/check.hpp"
#include "tests/model/tool_scenes.hpp"

namespace {

using namespace palpate;

/// A run with what a test asks about every tick.
struct Insertion {
  explicit Insertion(const Scene& scene) : simulation(scene), row(simulation.columns().size()) {
    read();
  }
  bool tick() {
    const bool ok = simulation.tick() == StepStatus::ok;
    read();
    return ok;
  }
  void read() {
    simulation.sample(row);
    simulation.sample_text(words, events);
    tool = simulation.tool();
  }
  template <class Body>
  void run(Body&& body) {
    while (simulation.ticks() < simulation.tick_count()) {
      if (!tick()) {
        CHECK(!"diverged");
        return;
      }
      body();
    }
  }
  void run() {
    run([] {});
  }
  [[nodiscard]] std::string names() const {
    std::string all;
    for (const Event& e : events) { all += (all.empty() ? "" : " ") + e.kind; }
    return all;
  }
  [[nodiscard]] double time_of(const std::string& kind, const std::string& label) const {
    const auto found = std::ranges::find_if(
        events, [&](const Event& e) { return e.kind == kind && e.detail == label; });
    return found == events.end() ? -1.0 : found->time;
  }

  Simulation simulation;
  std::vector<double> row;
  std::vector<std::string> words{"", ""};
  std::vector<Event> events;
  ToolReport tool;
};

/// Substeps: automatic unless given.
Scene timed(Scene scene, double duration, double step,
            const std::string& integrator = "velocity-verlet", std::optional<int> substeps = {}) {
  scene.simulation = {
      .duration = duration, .step = step, .substeps = substeps, .integrator = integrator};
  return scene;
}

/// The whole way in a quarter of the time.
Scene pushed_quickly(Scene scene) {
  scene.drive->speed *= 4.0;
  return scene;
}

TEST("a needle meets its layers in order and loses resistance in the epidural space") {
  Insertion run(timed(layered_scene(), 0.75, 1e-3));
  double peak = 0.0;
  run.run([&] { peak = std::max(peak, run.tool.forces.total); });
  CHECK(run.names() == "contact puncture puncture loss-of-resistance");
  CHECK(run.events.front().time == 0.0);
  CHECK(run.tool.forces.cutting == 0.0);
  CHECK(run.tool.depth > 0.010);
  // F_c of the ligament and the friction of the whole track.
  CHECK(peak > 0.15 && peak < 0.15 + 2.0 * 0.004 + 5.0 * 0.006 + 1e-9);
  CHECK(run.words[0] == "epidural space");
}

TEST("the parts add up to the total, and the total is what a prescribed drive applies") {
  Insertion run(timed(layered_scene(), 0.5, 1e-3));
  run.run([&] {
    const ToolForces& f = run.tool.forces;
    CHECK(f.total == f.cutting + f.friction + f.stiffness);
    CHECK(f.applied == f.total);
    CHECK(f.cutting == 0.0 || f.stiffness == 0.0);
  });
}

#ifndef PALPATE_SANITIZED  // slow pushes go through the same code as quick ones, for two minutes
TEST("before the first puncture the force is the stiffness of a chain times the depth") {
  Scene scene = timed(chain_scene(), 1.9, 1e-3);
  scene.drive->speed = 1e-3;  // 1.9 mm; the skin gives way at 2 mm
  Insertion run(scene);
  run.run([&] {  // after the jolt of the first contact
    if (run.simulation.time() < 0.1) { return; }
    CHECK_NEAR(run.tool.forces.stiffness, 50.0 * run.tool.place, 1e-4);
  });
  CHECK(run.names() == "contact");
}

TEST("the tip sticks until the cutting force and punctures there") {
  Scene scene = timed(chain_scene(), 2.1, 1e-3);
  scene.drive->speed = 1e-3;
  Insertion run(scene);
  run.run();
  CHECK(run.names() == "contact puncture");
  CHECK_NEAR(run.time_of("puncture", "skin"), 0.1 / 50.0 / 1e-3, 2e-3);
  CHECK(run.tool.forces.cutting == 0.1);
}
#endif

TEST("a needle drawn back and put in again cuts nothing on its old track, but rubs") {
  Scene scene = timed(layered_scene(), 1.2, 1e-3);
  scene.drive->depth = 0.006;
  scene.drive->hold = 0.05;
  scene.drive->withdraw_speed = 0.02;
  Insertion run(scene);
  double backwards = 0.0;
  run.run([&] { backwards = std::min(backwards, run.tool.forces.friction); });
  CHECK(run.names() == "contact puncture puncture withdrawn");
  CHECK(backwards < 0.0);
}

TEST("what rests under less than its limit stays where it is") {
  Scene scene = timed(chain_scene(), 100.0, 1e-3);
  scene.drive = Drive{.kind = Drive::Kind::force, .force = 0.08, .rise = 0.1, .hand_viscosity = 5.0};
  Insertion run(scene);
#ifdef PALPATE_SANITIZED  // the same code, and no time to see a creep
  constexpr int watched = 2000;
#else
  constexpr int watched = 90000;
#endif
  constexpr int settling = 10000;
  for (int n = 0; n < settling; ++n) { run.simulation.tick(); }
  run.read();
  const double place = run.tool.place;
  for (int n = 0; n < watched; ++n) { run.simulation.tick(); }
  run.read();
  CHECK_NEAR(run.tool.place, place, 1e-12);
  CHECK_NEAR(run.tool.forces.stiffness, 0.08, 1e-9);
}

TEST("the hand's force, the tissue's and inertia balance") {
  Scene scene = timed(layered_scene(), 0.5, 1e-4);
  scene.drive = Drive{.kind = Drive::Kind::force, .force = 0.25, .rise = 0.4};
  Insertion run(scene);
  double before = run.tool.velocity;
  double force = run.tool.forces.applied - run.tool.forces.total;
  double momentum = 0.0;
  run.run([&] {
    const double now = run.tool.forces.applied - run.tool.forces.total;
    momentum += 0.5 * 1e-4 * (force + now);
    force = now;
  });
  // Impulses of plastic impacts come on top of the forces; they are a thousandth here.
  CHECK_NEAR(momentum, run.tool.mass * (run.tool.velocity - before), 2e-3 * run.tool.mass * 0.1);
}

TEST("a hundred newtons do not move a tip into bone") {
  Scene scene = timed(layered_scene(), 2.0, 1e-3);
  scene.materials.push_back({.name = "bone", .youngs_modulus = 1e6, .role = TissueRole::bone});
  scene.tissue.layers[1] = {"lamina", "bone", 0.006};
  scene.drive = Drive{.kind = Drive::Kind::force, .force = 100.0, .rise = 1.0};
  Insertion run(scene);
  double deepest = 0.0;
  run.run([&] { deepest = std::max(deepest, run.tool.place); });
  CHECK(deepest <= 0.004);
  CHECK_NEAR(run.tool.place, 0.004, 1e-15);
  CHECK(run.names() == "contact puncture bone");
  CHECK_NEAR(run.tool.forces.total, run.tool.forces.applied, 1e-9);
}

TEST("a prescribed trajectory into bone goes on without the tool") {
  Scene scene = timed(layered_scene(), 0.5, 1e-3);
  scene.materials.push_back({.name = "bone", .youngs_modulus = 1e6, .role = TissueRole::bone});
  scene.tissue.layers[1] = {"lamina", "bone", 0.006};
  Insertion run(scene);
  run.run();
  CHECK_NEAR(run.tool.place, 0.004, 1e-15);
  CHECK_NEAR(run.tool.forces.stiffness, 5000.0 * (0.02 * 0.5 - 0.004), 0.5);
}

TEST("a probe cuts nothing and rubs nothing") {
  Scene scene = timed(layered_scene(), 0.3, 1e-3);
  scene.needle.reset();
  scene.probe = Probe{.size = {0.004, 0.004}};
  Insertion run(scene);
  run.run([&] {
    CHECK(run.tool.forces.cutting == 0.0 && run.tool.forces.friction == 0.0);
    CHECK(run.tool.forces.lateral == 0.0);
  });
  CHECK(run.tool.forces.stiffness > 0.0);
  CHECK(run.names() == "contact");
}

TEST("work of the hand is stored, lost in dampers, cutting, friction and impacts, or moves") {
  const double h = 1e-5;
  Scene scene = timed(pushed_quickly(layered_scene()), 0.15, h, "rk4", 1);
  scene.output.audit = true;
  Insertion run(scene);
  const double initial = run.simulation.energy();
  run.run();
  const ToolLosses& lost = run.tool.losses;
  const double hand = lost.hand + lost.jerk;
  const double rest = hand - (run.simulation.energy() - initial) - lost.damping - lost.cutting -
                      lost.friction - lost.impact;
  CHECK(run.names() == "contact puncture puncture loss-of-resistance");
  CHECK(hand > 1e-3);
  CHECK_NEAR(rest / hand, 0.0, 1e-6);
}

TEST("slanting needles press sideways, straight ones do not") {
  Scene straight = timed(layered_scene(), 0.4, 1e-3);
  Insertion along(straight);
  along.run([&] { CHECK(along.tool.forces.lateral < 1e-9); });
  Scene slanting = straight;
  slanting.needle->direction = {std::tan(0.26), 0.0, 1.0};
  Insertion aside(slanting);
  aside.run();
  CHECK(aside.tool.forces.lateral > 1e-3);
}

TEST("every scheme that may carry a tool gives the same force, to its order") {
  const auto scene = [](const char* name, int substeps) {
    return timed(pushed_quickly(layered_scene()), 0.1, 1e-3, name, substeps);
  };
  Insertion best(scene("rk4", 200));
  best.run();
  for (const char* name : {"euler-cromer", "velocity-verlet", "implicit-midpoint", "implicit-euler",
                           "feynman-newton-printed"}) {
    Insertion run(scene(name, 50));
    run.run();
    CHECK_NEAR(run.tool.forces.total, best.tool.forces.total, 5e-3);
    CHECK_NEAR(run.tool.depth, best.tool.depth, 5e-5);
    CHECK(run.names() == "contact puncture puncture");
  }
}

TEST("in single precision a needle does what it does in double") {
  Scene scene = timed(layered_scene(), 0.4, 1e-3);
  Insertion exact(scene);
  scene.simulation.precision = Precision::single_precision;
  Insertion single(scene);
  exact.run();
  single.run();
  CHECK_NEAR(single.tool.forces.total, exact.tool.forces.total, 2e-2);
  CHECK(single.names() == exact.names());
}

}  // namespace
