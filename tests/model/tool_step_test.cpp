// SPDX-License-Identifier: MIT
/// A free tool in stiff tissue with ticks far longer than its motion against it takes: tip and shaft
/// keep to their laws within each implicit step.
#include <algorithm>
#include <cmath>

#include "model/stepping/simulation.hpp"
#include "tests/check.hpp"
#include "tests/model/tool_scenes.hpp"

namespace {

using namespace palpate;

/// A hand with 20 N s/m pushes 20 g into ligaments of 15 MPa: 1 ms is the time that hand and tool
/// take, and ten times that of tool on tissue.
Scene stiff_scene(double step) {
  Scene scene = layered_scene();
  for (Material& m : scene.materials) {
    m.youngs_modulus = 15e6;
    m.cutting_force *= 30.0;
    m.friction *= 30.0;
  }
  scene.drive = Drive{.kind = Drive::Kind::force, .from = 0.0, .force = 8.0, .rise = 0.5,
                      .hand_viscosity = 20.0};
  scene.simulation = {.duration = 0.5, .step = step, .integrator = "implicit-euler"};
  return scene;
}

struct Sample {
  double place, velocity, slip, cutting, friction, stiffness;
};

std::vector<Sample> run(const Scene& scene) {
  Simulation simulation(scene);
  std::vector<Sample> samples;
  const auto every = static_cast<long>(std::lround(1e-3 / scene.simulation.step));
  while (simulation.ticks() < simulation.tick_count()) {
    if (simulation.tick() != StepStatus::ok) {
      CHECK(!"diverged");
      break;
    }
    if (simulation.ticks() % every != 0) { continue; }
    const ToolReport tool = simulation.tool();
    samples.push_back({tool.place, tool.velocity, tool.slip, tool.forces.cutting,
                       tool.forces.friction, tool.forces.stiffness});
  }
  return samples;
}

/// Times that a quantity turned round.
template <class Of>
int turns(const std::vector<Sample>& samples, Of of) {
  int count = 0;
  for (std::size_t n = 2; n < samples.size(); ++n) {
    const double before = of(samples[n - 1]) - of(samples[n - 2]);
    const double after = of(samples[n]) - of(samples[n - 1]);
    count += before * after < 0.0 && std::abs(before) + std::abs(after) > 0.2 ? 1 : 0;
  }
  return count;
}

TEST("under a rising push the tool never moves back, and friction opposes what slips") {
  const std::vector<Sample> samples = run(stiff_scene(1e-3));
  for (std::size_t n = 1; n < samples.size(); ++n) {
    CHECK(samples[n].place >= samples[n - 1].place - 1e-9);
    // Below 1 mN tip and shaft still share their nodes, and their forces cannot be told apart.
    CHECK(samples[n].friction * samples[n].slip >= 0.0 || std::abs(samples[n].slip) < 1e-9 ||
          std::abs(samples[n].friction) < 1e-3);
  }
}

TEST("long ticks do not make the force chatter") {
  const auto force = [](const Sample& s) { return s.cutting + s.friction + s.stiffness; };
  const std::vector<Sample> coarse = run(stiff_scene(1e-3));
  const std::vector<Sample> fine = run(stiff_scene(1e-3 / 16.0));
  CHECK(turns(coarse, force) <= turns(fine, force) + 2);
}

/// Most that tip and shaft can resist with at a depth of the stiff scene [N]: F_c of the deepest layer
/// reached and what rubs on the way.
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

TEST("in no step do tip and shaft take more from the tool than cutting and friction allow") {
  Scene scene = stiff_scene(1e-3);
  scene.drive->rise = 0.02;  // sticking ends within a tick, with force to spare
  Simulation simulation(scene);
  const double strongest_friction = std::ranges::max(scene.materials, {}, &Material::friction).friction;
  double before = 0.0;
  double depth = 0.0;
  double way = 0.0;
  double worst = 0.0;
  while (simulation.ticks() < simulation.tick_count()) {
    CHECK(simulation.tick() == StepStatus::ok);
    const ToolReport tool = simulation.tool();
    const double taken = tool.forces.applied - tool.mass * (tool.velocity - before) / 1e-3;
    // A step's depth is led on at the rate of the step before: L is off by the change of the way.
    const double led_on = strongest_friction * std::abs(tool.depth - depth - way);
    before = tool.velocity;
    way = tool.depth - depth;
    depth = tool.depth;
    worst = std::max(worst, taken - most_resistance(scene, tool.depth) - led_on);
  }
  CHECK(worst <= 1e-6);  // of 8 N: what the solver leaves
}

TEST("where long and short ticks both see the tool, it is at the same place") {
  const std::vector<Sample> coarse = run(stiff_scene(1e-3));
  const std::vector<Sample> fine = run(stiff_scene(1e-3 / 16.0));
  double worst = 0.0;
  for (std::size_t n = 0; n < std::min(coarse.size(), fine.size()); ++n) {
    worst = std::max(worst, std::abs(coarse[n].place - fine[n].place));
  }
  // Events are found to a tick, in which the tool moves at most as fast as the hand lets it.
  double fastest = 0.0;
  for (const Sample& s : fine) { fastest = std::max(fastest, std::abs(s.velocity)); }
  CHECK(worst <= 1e-3 * fastest);
}

TEST("a solver that is asked for less leaves as little more as it is asked for") {
  Scene scene = stiff_scene(1e-3);
  scene.drive->from = -0.002;  // in air the first correction is exact, and says nothing of tissue
  const std::vector<Sample> all = run(scene);
  scene.simulation.solver_tolerance = 1e-6;
  const std::vector<Sample> less = run(scene);
  double fastest = 0.0;
  for (const Sample& s : all) { fastest = std::max(fastest, std::abs(s.velocity)); }
  for (std::size_t n = 0; n < all.size(); ++n) {
    CHECK_NEAR(less[n].place, all[n].place, 1e-6 * fastest * 0.5);  // of every step's way, added up
  }
  // And it does leave more: one correction is not all there is.
  CHECK(std::ranges::any_of(all, [&](const Sample& s) { return s.place != less[static_cast<std::size_t>(&s - all.data())].place; }));
}

TEST("a tolerance of a hundredth leaves the force of every tick within 1 % of its peak") {
  Scene scene = stiff_scene(1e-3);
  const auto force = [](const Sample& s) { return s.cutting + s.friction + s.stiffness; };
  const std::vector<Sample> all = run(scene);
  scene.simulation.solver_tolerance = 1e-2;
  const std::vector<Sample> less = run(scene);
  const double peak = force(*std::ranges::max_element(all, {}, force));
  CHECK(peak > 1.0);
  for (std::size_t n = 0; n < all.size(); ++n) { CHECK_NEAR(force(less[n]), force(all[n]), 0.01 * peak); }
}

}  // namespace
