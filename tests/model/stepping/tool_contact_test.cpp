// SPDX-License-Identifier: MIT

#include "model/stepping/tool_contact.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include "model/kernels/network_system.hpp"
#include "model/problem/problem.hpp"
#include "model/stepping/integrator.hpp"
#include "model/stepping/simulation.hpp"
#include "model/stepping/tool_system.hpp"
#include "model/tissue/network_builder.hpp"
#include "tests/check.hpp"
#include "tests/model/sample_scenes.hpp"

namespace PALPATE_FILE {

using namespace palpate;

/// Run with the quantities that tests check at every tick.
struct Insertion {
  explicit Insertion(const Scene& scene) : simulation(scene), row(simulation.columns().size()) {
    read();
  }
  void read() {
    simulation.sample(row);
    simulation.sample_text(words, events);
    tool = simulation.tool();
  }
  /// Runs to the end; `body` is called after every tick.
  void run(const std::function<void()>& body = [] {}) {
    while (simulation.ticks() < simulation.tick_count()) {
      REQUIRE(simulation.tick() == StepStatus::ok);
      read();
      body();
    }
  }
  [[nodiscard]] std::string names() const {
    std::string all;
    for (const Event& e : events) { all += (all.empty() ? "" : " ") + e.kind; }
    return all;
  }

  Simulation simulation;
  std::vector<double> row;
  std::vector<std::string> words{"", ""};
  std::vector<Event> events;
  ToolReport tool;
};

/// Number of substeps; automatic if not given.
Scene timed(Scene scene, double duration, double step,
            const std::string& integrator = "velocity-verlet", std::optional<int> substeps = {}) {
  scene.simulation = {
      .duration = duration, .step = step, .substeps = substeps, .integrator = integrator};
  return scene;
}

TEST("the lateral force is the part of the tissue's force across the needle") {
  Scene scene = timed(layered_scene(), 0.3, 1e-3);
  scene.needle->direction = {std::sin(0.5), 0.0, std::cos(0.5)};
  Insertion run(scene);
  double largest = 0.0;
  run.run([&] {
    const ToolForces& f = run.tool.forces;
    CHECK_NEAR(f.lateral, f.on_tool.cross(scene.needle->direction).norm(), 1e-12);  // rounding
    largest = std::max(largest, f.lateral);
  });
  CHECK(largest > 1e-3);
}

TEST("a needle meets its layers in order and loses resistance in the epidural space") {
  Insertion run(timed(layered_scene(), 0.75, 1e-3));
  double peak = 0.0;
  run.run([&] {
    const ToolForces& f = run.tool.forces;
    peak = std::max(peak, f.total);
    CHECK(f.cutting * f.stiffness == 0.0);  // the tip sticks or cuts
    CHECK(f.total == f.cutting + f.friction + f.stiffness);
    CHECK(f.applied == f.total);
    CHECK(f.lateral < 1e-9);  // of a straight needle
  });
  CHECK(run.names() == "contact puncture puncture loss-of-resistance");
  CHECK(run.events.front().time == 0.0);
  CHECK(run.tool.forces.cutting == 0.0);
  CHECK(run.tool.depth > 0.010);
  CHECK(peak > 0.15);
  // F_c of the ligament and the friction along the whole track.
  CHECK(peak < 0.15 + 2.0 * 0.004 + 5.0 * 0.006 + 1e-9);
  CHECK(run.words[0] == "epidural space");
}

TEST("a tip under less than its cutting force does not creep") {
  Scene scene = timed(chain_scene(), 100.0, 1e-3);
  scene.drive =
      Drive{.kind = Drive::Kind::force, .force = 0.08, .rise = 0.1, .hand_viscosity = 5.0};
  Insertion run(scene);
  constexpr int watched = check::sanitized ? 2000 : 90000;
  const auto place_after = [&](int ticks) {
    for (int n = 0; n < ticks; ++n) { run.simulation.tick(); }
    run.read();
    return run.tool.place;
  };
  const double place = place_after(10000);
  (void)place_after(watched);
  CHECK_NEAR(run.tool.place, place, 1e-12);
  CHECK_NEAR(run.tool.forces.stiffness, 0.08, 1e-9);
}

TEST("a crack begins at the puncture force and grows at the cutting force") {
  for (const char* scheme : {"velocity-verlet", "implicit-euler"}) {
    Scene scene = timed(layered_scene(), 0.75, 1e-3, scheme);
    for (Material& material : scene.materials) { material.friction = 0.0; }
    scene.materials[0].puncture_force = 0.3;
    scene.materials[1].puncture_force = 0.4;
    Insertion run(scene);
    double before = 0.0;
    std::vector<double> at_puncture;
    std::vector<double> while_cutting;
    run.run([&] {
      const ToolForces& f = run.tool.forces;
      if (f.cutting > 0.0 && while_cutting.size() < 500) { while_cutting.push_back(f.cutting); }
      if (before > 0.2 && f.stiffness == 0.0) { at_puncture.push_back(before); }
      before = f.stiffness;
    });
    CHECK(run.names() == "contact puncture puncture loss-of-resistance");
    REQUIRE(at_puncture.size() == 2);
    // A tick of 1 ms moves the tip by 0.02 mm; the contact has some 200 N/m.
    CHECK_NEAR(at_puncture[0], 0.3, 0.02);
    CHECK_NEAR(at_puncture[1], 0.4, 0.02);
    for (const double force : while_cutting) {
      CHECK_NEAR(std::min(std::abs(force - 0.1), std::abs(force - 0.15)), 0.0, 0.0);
    }
  }
}

TEST("a tip that sinks onto a layer with more than it bears punctures it at once") {
  for (const char* scheme : {"velocity-verlet", "implicit-euler"}) {
    Scene scene = timed(layered_scene(), 0.5, 1e-3, scheme);
    for (Material& material : scene.materials) { material.friction = 0.0; }
    scene.materials.push_back(scene.materials[0]);
    scene.materials.back().name = "fat";
    scene.materials.back().cutting_force = 0.002;
    scene.materials[0].cutting_force = 0.3;
    scene.materials[1].cutting_force = 0.02;
    scene.materials[1].puncture_force = 0.05;
    scene.tissue.layers = {{"skin", "soft", 0.001},
                           {"fat", "fat", 0.0002},
                           {"ligament", "firm", 0.0088},
                           {"epidural space", "loose", 0.006}};
    Insertion run(scene);
    double largest = 0.0;  // force of a tip that sticks, after the skin
    run.run([&] {
      if (run.events.size() > 2) { largest = std::max(largest, run.tool.forces.stiffness); }
    });
    REQUIRE(run.events.size() > 3);
    CHECK(run.names().starts_with("contact puncture puncture puncture"));
    CHECK_NEAR(run.events[3].time, run.events[2].time, 0.0);
    CHECK(largest < 0.03);  // of a crack that goes on, not of a puncture
  }
}

TEST("a tip that comes through a gap dents the tissue behind it before it cuts it") {
  Scene scene = timed(layered_scene(), 1.6, 1e-3, "implicit-euler");
  for (Material& material : scene.materials) {
    material.friction = 0.0;
    material.retardation_time = 5e-3;
  }
  scene.tissue.fixed = {Face::x_min, Face::x_max, Face::y_min, Face::y_max, Face::z_max};
  scene.materials[0].cutting_force = 0.05;
  scene.materials[0].puncture_force = 1.5;
  scene.materials[1].cutting_force = 0.02;
  scene.materials[1].puncture_force = 0.6;
  scene.tissue.layers = {{"sheet", "soft", 0.004},
                         {.tissue = "air", .thickness = 0.004, .gap = true},
                         {"ground", "firm", 0.012}};
  Insertion run(scene);
  double dent = 0.0;
  double sheet = 0.0;
  double force = 0.0;
  run.run([&] {
    if (run.events.size() == 1) { sheet = run.tool.place; }
    if (run.events.size() == 3) {
      dent = run.tool.place - 0.008;
      force = std::max(force, run.tool.forces.stiffness);
    }
  });
  REQUIRE(run.events.size() == 4);
  CHECK(run.names() == "contact puncture puncture puncture");
  // The sheet gives way until its tip is behind the surface of the ground, which is not cut then.
  CHECK(sheet > 0.008);
  CHECK(run.events[3].time > run.events[2].time);
  CHECK(dent > 1e-3);
  CHECK_NEAR(force, 0.6, 0.02);
}

TEST("creeping friction of two tissues turns with the needle and balances its energy") {
  std::vector<double> begun;  // friction of each scheme 15 ms after the puncture
  for (const char* scheme : {"velocity-verlet", "implicit-euler"}) {
    Scene scene = timed(layered_scene(), 1.6, 1e-3, scheme);
    scene.output.audit = true;
    // The tissue that the shaft drags along leaves it above the skin.
    scene.drive =
        Drive{.from = -0.003, .speed = 0.02, .depth = 0.010, .hold = 0.2, .withdraw_speed = 0.02};
    for (std::size_t n = 0; n < 2; ++n) {
      Material& material = scene.materials[n];
      material.friction = 20.0;
      material.friction_travel = 1e-3;
      material.friction_exponent = 0.2;
    }
    Insertion run(scene);
    double largest = 0.0;
    double least = 0.0;
    double last = 0.0;
    double jump = 0.0;
    const double rest = run.simulation.energy();
    run.run([&] {
      const double friction = run.tool.forces.friction;
      largest = std::max(largest, friction);
      least = std::min(least, friction);
      jump = std::max(jump, std::abs(friction - last));
      last = friction;
      if (run.simulation.ticks() == 215) { begun.push_back(friction); }
    });
    const double full = 20.0 * 0.010 * std::pow(20.0, 0.2);  // sliding with the drive's speed
    CHECK(largest > 0.3 * full);  // the tissue moves along, so it does not reach all of it
    CHECK(largest < full);
    CHECK(least < -0.3 * full);
    CHECK(least > -full);
    CHECK(run.tool.losses.friction > 0.0);
    // 0.02 mm a tick: a fiftieth of the travel, in which the whole friction of 0.36 N develops.
    CHECK(jump < full / 50.0);
    CHECK_NEAR(last, 0.0, 1e-12);  // rounding at the skin
    const ToolLosses& lost = run.tool.losses;
    const double work = lost.hand + lost.jerk;
    const double spent =
        lost.cutting + lost.friction + lost.damping + lost.impact + run.simulation.energy() - rest;
    CHECK_NEAR(spent / work, 1.0, 0.01);  // steps of first order
  }
  CHECK(begun[0] > 1e-3);
  CHECK_NEAR(begun[1], begun[0], 0.1 * begun[0]);  // a tick of 1 ms is a fifteenth
}

TEST("tissue that follows the shaft on its way out encloses more of it") {
  Scene scene = timed(layered_scene(), 1.2, 1e-3, "implicit-euler");
  scene.drive = Drive{.speed = 0.02, .depth = 0.008, .withdraw_speed = 0.02};
  scene.tissue.layers.resize(1);
  scene.tissue.layers[0].thickness = 0.03;
  scene.materials[0].friction = 20.0;
  scene.materials[0].friction_travel = 1e-3;
  Insertion run(scene);
  double least = 0.0;
  double depth = 0.0;
  run.run([&] {
    if (run.tool.forces.friction < least) {
      least = run.tool.forces.friction;
      depth = run.tool.depth;
    }
  });
  REQUIRE(least < -0.05);
  // All of the travel is used up: L = f (xi + delta). A tick moves the tip by 0.02 mm.
  CHECK_NEAR(-least, 20.0 * (depth + 1e-3), 20.0 * 0.05e-3);
}

TEST("tissue that has relaxed does not push a tool that has left it") {
  Scene needle = layered_scene();
  for (Material& material : needle.materials) { material.relaxation = {{0.5, 0.05}}; }
  needle.drive = Drive{.speed = 0.02, .depth = 5e-4, .hold = 0.2, .withdraw_speed = 0.005};
  Scene probe = needle;
  probe.needle.reset();
  probe.probe = Probe{.size = {0.004, 0.004}};
  for (const Scene& scene : {needle, probe}) {
    for (const std::string scheme : {"velocity-verlet", "implicit-euler"}) {
      Insertion run(timed(scene, 0.4, 1e-3, scheme));
      double largest = 0.0;
      bool left = false;
      run.run([&] {
        const double force = run.tool.forces.stiffness;
        largest = std::max(largest, force);
        left = left || (largest > 0.0 && run.simulation.time() > 0.23 && force == 0.0);
        if (left) { CHECK_NEAR(force, 0.0, 1e-9 * largest); }
      });
      CHECK(left);
      CHECK(largest > 1e-4);
      CHECK(run.names() == "contact withdrawn");
    }
  }
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
  // Impulses of plastic impacts are added to the forces; they are about a thousandth here.
  CHECK_NEAR(momentum, run.tool.mass * (run.tool.velocity - before), 2e-3 * run.tool.mass * 0.1);
}

TEST("a prescribed trajectory continues into bone, and the tool does not") {
  Scene scene = timed(layered_scene(), 0.5, 1e-3);
  scene.materials.push_back({.name = "bone", .youngs_modulus = 1e6, .role = TissueRole::bone});
  scene.tissue.layers[1] = {"lamina", "bone", 0.006};
  Insertion run(scene);
  run.run();
  CHECK(run.names() == "contact puncture bone");
  CHECK_NEAR(run.tool.place, 0.004, 1e-15);
  CHECK_NEAR(run.tool.forces.stiffness, 5000.0 * (0.02 * 0.5 - 0.004), 0.5);
}

TEST("a probe has no cutting, friction or lateral force") {
  Scene scene = timed(layered_scene(), 0.15, 1e-3);  // from 0.2 s on a cell is turned inside out
  scene.needle.reset();
  scene.probe = Probe{.size = {0.004, 0.004}};
  Insertion run(scene);
  run.run([&] {
    CHECK(run.tool.forces.cutting == 0.0);
    CHECK(run.tool.forces.friction == 0.0);
    CHECK(run.tool.forces.lateral == 0.0);
  });
  CHECK(run.tool.forces.stiffness > 0.0);
  CHECK(run.names() == "contact");
}

TEST("a spherical fingertip at rest has one force, whatever the scheme, the drive and relaxation") {
  for (const bool relaxes : {false, true}) {
    Scene scene = layered_scene();
    scene.needle.reset();
    scene.probe = Probe{.size = {0.006, 0.006}, .tip_radius = 0.004};
    for (Material& material : scene.materials) {
      if (relaxes) { material.relaxation = {{0.5, 0.02}}; }
    }
    constexpr double depth = 4e-4;
    std::vector<double> forces;
    for (const char* scheme : {"velocity-verlet", "implicit-euler"}) {
      Scene pressed = timed(scene, 0.6, 1e-3, scheme);
      pressed.drive = Drive{.speed = 0.01, .depth = depth, .hold = 1.0};
      Insertion run(pressed);
      run.run([&] { CHECK(run.tool.forces.stiffness >= 0.0); });
      CHECK(run.names() == "contact");
      forces.push_back(run.tool.forces.stiffness);
      // The same force by the hand gives the same depth.
      pressed.drive = Drive{
          .kind = Drive::Kind::force, .force = forces.back(), .rise = 0.1, .hand_viscosity = 5.0};
      pressed.probe->mass = 0.01;
      Insertion pushed(pressed);
      pushed.run();
      CHECK_NEAR(pushed.tool.place / depth, 1.0, 0.01);
    }
    CHECK_NEAR(forces[1] / forces[0], 1.0, 2e-3);
    // A flat face at the same depth has more than one and a half times the force of a sphere of
    // half a space, 2 E A D / (1 - nu^2) over 4 E sqrt(R) D^1.5 / (3 (1 - nu^2)).
    scene.probe->tip_radius.reset();
    Scene flat = timed(scene, 0.6, 1e-3, "implicit-euler");
    flat.drive = Drive{.speed = 0.01, .depth = depth, .hold = 1.0};
    Insertion run(flat);
    run.run();
    CHECK(run.tool.forces.stiffness > 1.5 * forces[0]);
  }
}

TEST("every scheme that may carry a tool gives the same force, to its order") {
  const auto scene = [](const char* name, int substeps) {
    Scene quick = timed(layered_scene(), 0.1, 1e-3, name, substeps);
    quick.drive->speed *= 4.0;
    return quick;
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

// Free tool in stiff tissue with ticks much longer than its time constant: tip and shaft satisfy
// their laws within each implicit step.

/// Scene in which a hand with 20 N s/m drives 20 g into ligaments of 15 MPa. The time constant of
/// hand and tool is 1 ms, ten times that of tool and tissue.
Scene stiff_scene(double step) {
  Scene scene = layered_scene();
  for (Material& m : scene.materials) {
    m.youngs_modulus = 15e6;
    m.cutting_force *= 30.0;
    m.friction *= 30.0;
  }
  scene.drive = Drive{
      .kind = Drive::Kind::force, .from = 0.0, .force = 8.0, .rise = 0.5, .hand_viscosity = 20.0};
  scene.simulation = {.duration = 0.5, .step = step, .integrator = "implicit-euler"};
  return scene;
}

/// Reports of the tool at every millisecond.
std::vector<ToolReport> run(const Scene& scene) {
  Simulation simulation(scene);
  std::vector<ToolReport> samples;
  const auto every = static_cast<long>(std::lround(1e-3 / scene.simulation.step));
  while (simulation.ticks() < simulation.tick_count()) {
    REQUIRE(simulation.tick() == StepStatus::ok);
    if (simulation.ticks() % every == 0) { samples.push_back(simulation.tool()); }
  }
  return samples;
}

double force_of(const ToolReport& tool) {
  return tool.forces.cutting + tool.forces.friction + tool.forces.stiffness;
}

double fastest(const std::vector<ToolReport>& samples) {
  double speed = 0.0;
  for (const ToolReport& s : samples) { speed = std::max(speed, std::abs(s.velocity)); }
  return speed;
}

/// Number of reversals of the force.
int turns(const std::vector<ToolReport>& samples) {
  int count = 0;
  for (std::size_t n = 2; n < samples.size(); ++n) {
    const double before = force_of(samples[n - 1]) - force_of(samples[n - 2]);
    const double after = force_of(samples[n]) - force_of(samples[n - 1]);
    count += before * after < 0.0 && std::abs(before) + std::abs(after) > 0.2 ? 1 : 0;
  }
  return count;
}

TEST("long ticks move the tool under a rising push as short ones do, without chatter") {
  const std::vector<ToolReport> coarse = run(stiff_scene(1e-3));
  const std::vector<ToolReport> fine = run(stiff_scene(1e-3 / 16.0));
  CHECK(turns(coarse) <= turns(fine) + 2);
  REQUIRE(coarse.size() == fine.size());
  for (std::size_t n = 0; n < fine.size(); ++n) {
    // Events are located to one tick, in which the tool moves at most at the speed of the hand.
    CHECK_NEAR(coarse[n].place, fine[n].place, 1e-3 * fastest(fine));
    if (n > 0) { CHECK(coarse[n].place >= coarse[n - 1].place - 1e-9); }
    // Friction opposes slip. Below 1 mN tip and shaft still share nodes, and their forces cannot be
    // separated.
    const double friction = coarse[n].forces.friction;
    CHECK((friction * coarse[n].slip >= 0.0 || std::abs(coarse[n].slip) < 1e-9 ||
           std::abs(friction) < 1e-3));
  }
}

/// Largest resistance of tip and shaft at a depth of the stiff scene [N]: F_c of the deepest layer
/// reached plus friction along the track.
double most_resistance(const Scene& scene, double depth) {
  double cutting = 0.0;
  double rubbing = 0.0;
  double top = 0.0;
  for (const Layer& layer : scene.tissue.layers) {
    const auto material = std::ranges::find(scene.materials, layer.material, &Material::name);
    if (depth < top) { break; }
    cutting = std::max(cutting, material->cutting_force);
    rubbing += material->friction * std::min(layer.thickness, depth - top);
    top += layer.thickness;
  }
  return cutting + rubbing;
}

TEST("a shaft at rest keeps its friction while only fixed nodes support the tip") {
  // The last node of the chain, at 20 mm, is fixed.
  for (const int substeps : {1, 2, 4}) {
    Scene scene = timed(chain_scene(), 1.6, 1e-3, "implicit-euler", substeps);
    scene.drive = Drive{.speed = 0.02, .depth = 0.0202};
    Insertion run(scene);
    double before = 0.0;
    run.run([&] {
      const double force = run.tool.forces.total;
      if (run.simulation.time() > 1.2) { CHECK_NEAR(force, before, 1e-6); }
      before = force;
    });
    CHECK(before > 0.01);  // the shaft still holds the tissue down
  }
}

TEST("in no step do tip and shaft exert more on the tool than cutting and friction allow") {
  Scene scene = stiff_scene(1e-3);
  scene.drive->rise = 0.02;  // sticking ends within a tick, with force to spare
  Simulation simulation(scene);
  const double strongest_friction =
      std::ranges::max(scene.materials, {}, &Material::friction).friction;
  double before = 0.0;
  double depth = 0.0;
  double way = 0.0;
  double worst = 0.0;
  bool entered = false;  // a layer, in the tick before: the depth jumped
  while (simulation.ticks() < simulation.tick_count()) {
    CHECK(simulation.tick() == StepStatus::ok);
    const ToolReport tool = simulation.tool();
    const double taken = tool.forces.applied - tool.mass * (tool.velocity - before) / 1e-3;
    // The depth of a step is extrapolated with the previous rate: the error of L is the change of
    // the displacement.
    // The rate also follows the slope of c_s, which changes from one piece of its table to the next
    // by less than a thousandth of the way here.
    const double led_on =
        strongest_friction *
        (std::abs(tool.depth - depth - (entered ? 0.0 : way)) + 1e-3 * std::abs(way));
    before = tool.velocity;
    way = tool.depth - depth;
    entered = (depth < 0.004) != (tool.depth < 0.004) || (depth < 0.01) != (tool.depth < 0.01);
    depth = tool.depth;
    worst = std::max(worst, taken - most_resistance(scene, tool.depth) - led_on);
  }
  CHECK(worst <= 1e-6);  // solver tolerance, for 8 N
}

TEST("a looser solver tolerance changes places and forces by no more than it allows") {
  Scene scene = stiff_scene(1e-3);
  const std::vector<ToolReport> all = run(scene);
  scene.simulation.solver_tolerance = 1e-2;
  const std::vector<ToolReport> least = run(scene);
  const double peak = force_of(*std::ranges::max_element(all, {}, force_of));
  CHECK(peak > 1.0);
  for (std::size_t n = 0; n < all.size(); ++n) {
    CHECK_NEAR(force_of(least[n]), force_of(all[n]), 0.01 * peak);
  }
  scene.drive->from = -0.002;  // in air the first correction is exact, and says nothing of tissue
  scene.simulation.solver_tolerance = 0.0;
  const std::vector<ToolReport> exact = run(scene);
  scene.simulation.solver_tolerance = 1e-6;
  const std::vector<ToolReport> less = run(scene);
  double differing = 0.0;
  for (std::size_t n = 0; n < exact.size(); ++n) {
    // Relative displacement error per step, summed.
    CHECK_NEAR(less[n].place, exact[n].place, 1e-6 * fastest(exact) * 0.5);
    differing += less[n].place != exact[n].place ? 1.0 : 0.0;
  }
  CHECK(differing > 0.0);  // one correction is not sufficient
}

// A network with a tool caches evaluated forces; the cache must not change the result of any
// scheme.

constexpr double h = 2e-5;

/// Tissue, tool and scheme of a scene, stepped manually.
class Stage {
 public:
  Stage(const Scene& scene, const IntegratorInfo& scheme)
      : scheme_(scheme),
        problem_(make_problem(scene)),
        network_(make_network_system<double>(network_problem(), {.integrator = &scheme, .h = h})),
        contact_(scene, network_problem(), network_->layout()),
        system_(*network_, contact_),
        integrator_(scheme.make<double>()) {
    const Eigen::Index dof = system_.dof();
    state_ = {Vector<double>::Zero(dof), Vector<double>::Zero(dof)};
    state_.position.head(network_->dof()) = network_->initial_position();
    contact_.begin(state_);
    integrator_->prepare(system_, state_, h);
    scratch_.setZero(dof);
  }
  void look() {
    const Vector<double>& v = t_ == 0.0 ? state_.velocity : integrator_->velocity_at(state_);
    energy_ = system_.measure(t_, load_gate(t_, h), state_.position, v, scratch_);
  }
  void step() {
    if (t_ == 0.0) { integrator_->start(system_, state_, 0.0, h); }
    if (contact_.begin_step(t_, h, state_, scheme_.theta)) {
      system_.forget();
      ++jumps_;
    }
    integrator_->step(system_, state_, t_, h);
    t_ += h;
    contact_.end_step(t_, state_);
  }
  [[nodiscard]] const State<double>& state() const { return state_; }
  [[nodiscard]] int jumps() const { return jumps_; }
  /// Energy of the springs [J], from the force evaluation and from the network.
  [[nodiscard]] double energy() const { return energy_; }
  [[nodiscard]] double energy_asked() const {
    return network_->energy(state_.position, Vector<double>::Zero(system_.dof()));
  }

 private:
  const NetworkProblem& network_problem() const {
    return dynamic_cast<const NetworkProblem&>(*problem_);
  }

  const IntegratorInfo& scheme_;
  std::unique_ptr<Problem> problem_;
  std::unique_ptr<NetworkSystem<double>> network_;
  ToolContact<double> contact_;
  ToolSystem<double> system_;
  std::unique_ptr<Integrator<double>> integrator_;
  State<double> state_;
  Vector<double> scratch_;
  double t_ = 0.0;
  double energy_ = 0.0;
  int jumps_ = 0;
};

void compare(const Scene& scene, int steps, int least_jumps) {
  for (const IntegratorInfo* scheme : integrators()) {
    Stage seen(scene, *scheme);
    Stage unseen(scene, *scheme);
    for (int n = 0; n < steps; ++n) {
      seen.look();
      CHECK_NEAR(seen.energy(), seen.energy_asked(), 1e-12 * seen.energy());
      seen.step();
      unseen.step();
    }
    CHECK(seen.state().position == unseen.state().position);
    CHECK(seen.state().velocity == unseen.state().velocity);
    CHECK(seen.energy() > 0.0);
    CHECK(seen.jumps() >= least_jumps);
  }
}

TEST("evaluating forces between steps changes no bit, with a tool on a path or pushed") {
  Scene scene = layered_scene();
  scene.drive = Drive{
      .technique = Drive::Technique::intermittent, .speed = 0.02, .advance = 1e-4, .pause = 1e-3};
  compare(scene, 500, 3);
  scene.drive = Drive{.kind = Drive::Kind::force, .from = 0.0, .force = 2.0, .rise = 0.005};
  compare(scene, 500, 0);
}

}  // namespace PALPATE_FILE
