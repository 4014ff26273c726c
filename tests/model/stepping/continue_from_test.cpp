// SPDX-License-Identifier: MIT
// A simulation that goes on from the state of another one, with other materials.

#include <cmath>
#include <string>
#include <vector>

#include "model/stepping/simulation.hpp"
#include "tests/check.hpp"
#include "tests/model/sample_scenes.hpp"

namespace PALPATE_FILE {

using namespace palpate;

Scene needle_scene(std::string_view integrator, Precision precision = {}) {
  Scene scene = layered_scene();
  scene.simulation = {
      .duration = 0.6, .step = 1e-3, .integrator = std::string(integrator), .precision = precision};
  return scene;
}

/// Materials with volume terms that relax, a probe or a needle on them.
Scene relaxing_scene(bool needle) {
  Scene scene = needle_scene("implicit-euler");
  for (Material& material : scene.materials) {
    material.poissons_ratio = 0.4;
    material.relaxation = {{.share = 0.4, .time = 0.05}, {.share = 0.2, .time = 0.5}};
  }
  if (needle) { return scene; }
  scene.needle.reset();
  scene.probe = Probe{.size = {0.004, 0.004}};
  scene.drive = Drive{.speed = 0.02, .depth = 0.001};
  return scene;
}

Scene sliding_scene() {
  Scene scene = relaxing_scene(false);
  scene.tissue.block.nodes = {6, 6};
  scene.probe->path = {{0.1, -0.003, 0.0}, {0.5, 0.003, 0.001}};
  return scene;
}

Scene creeping_scene() {
  Scene scene = needle_scene("implicit-euler");
  for (Material& material : scene.materials) {
    if (material.friction == 0.0) { continue; }
    material.friction_travel = 1e-3;
    material.friction_exponent = 0.2;
  }
  return scene;
}

Scene reduced_scene() {
  Scene scene = needle_scene("implicit-euler");
  scene.tissue.block = {.nodes = {7, 7}, .spacing = 0.004, .connectivity = 26};
  scene.simulation.near_radius = 0.004;
  scene.simulation.far_modes = 12;
  return scene;
}

Scene pulled_lattice(double sleep_force) {
  Scene scene;
  scene.simulation = {.duration = 0.6,
                      .step = 1e-3,
                      .substeps = 1,
                      .integrator = "euler-cromer",
                      .sleep_force = sleep_force};
  scene.materials = {{.name = "gel", .youngs_modulus = 4e3, .damping_ratio = 0.3}};
  scene.tissue.lattice = {.nodes = {7, 7, 9}, .spacing = 0.01, .material = "gel"};
  scene.loads = {{.nodes = {24}, .force = {0.0, 0.0, -0.1}}};
  scene.records = {{"node", 24, {RecordedQuantity::position}}};
  return scene;
}

Scene with_factor(Scene scene, double factor) {
  for (Material& material : scene.materials) { material.youngs_modulus *= factor; }
  return scene;
}

void run(Simulation& simulation, long ticks) {
  for (long n = 0; n < ticks; ++n) { CHECK(simulation.tick() == StepStatus::ok); }
}

std::vector<double> row_of(Simulation& simulation) {
  std::vector<double> row(simulation.columns().size());
  simulation.sample(row);
  return row;
}

/// Largest change of a column and of a position, relative to the largest value of that column, if a
/// run goes on from its own state in a second simulation of the same scene.
double difference(const Scene& scene, long before, long after) {
  Simulation whole(scene);
  Simulation first(scene);
  Simulation second(scene);
  second.prepare_to_continue(first);
  run(whole, before);
  run(first, before);
  second.continue_from(first);
  CHECK(second.ticks() == before);
  std::vector<double> largest(whole.columns().size(), 1e-6);  // smaller values are rounding
  std::vector<double> apart(largest.size(), 0.0);
  double moved = 0.0;
  for (long n = 0; n <= after; ++n) {
    const std::vector<double> a = row_of(whole);
    const std::vector<double> b = row_of(second);
    for (std::size_t k = 0; k < a.size(); ++k) {
      largest[k] = std::max(largest[k], std::abs(a[k]));
      apart[k] = std::max(apart[k], std::abs(a[k] - b[k]));
    }
    moved =
        std::max(moved, (whole.node_positions() - second.node_positions()).cwiseAbs().maxCoeff());
    run(whole, 1);
    run(second, 1);
  }
  double worst = moved / 1e-3;
  for (std::size_t k = 0; k < apart.size(); ++k) { worst = std::max(worst, apart[k] / largest[k]); }
  return worst;
}

/// Ticks before a run goes on. 60: on the skin, 250: in the ligament.
const std::vector<long> moments = check::sanitized ? std::vector{60L} : std::vector{1L, 60L, 250L};

TEST("a run that goes on in an equal simulation has the same bits with schemes without memory") {
  for (const long ticks : moments) {
    CHECK(difference(needle_scene("euler-cromer"), ticks, 200) == 0.0);
    CHECK(difference(needle_scene("rk4"), ticks, 200) == 0.0);
  }
  CHECK(difference(needle_scene("euler-cromer", Precision::single_precision), 60, 200) == 0.0);
  for (const double sleep_force : {0.0, 1e-3}) {
    CHECK(difference(pulled_lattice(sleep_force), 20, 200) == 0.0);
  }
  Scene moving = moving_scene("euler-cromer");
  CHECK(difference(moving, 4, 50) == 0.0);
  moving.simulation.printed.lagged_velocity = true;
  CHECK(difference(moving, 4, 50) == 0.0);
}

TEST("a run that goes on in an equal simulation is the same up to the solver's tolerance") {
  // A staggered scheme starts again with half a step, an implicit one with another first guess.
  constexpr double rounding = 1e-7;
  CHECK(difference(moving_scene("leapfrog"), 4, 50) <= rounding);
  for (const long ticks : moments) {
    CHECK(difference(needle_scene("implicit-euler"), ticks, 80) <= rounding);
    CHECK(difference(relaxing_scene(true), ticks, 80) <= rounding);
    CHECK(difference(relaxing_scene(false), ticks, 80) <= rounding);
    CHECK(difference(creeping_scene(), ticks, 80) <= rounding);
    CHECK(difference(reduced_scene(), ticks, 80) <= rounding);
    CHECK(difference(sliding_scene(), ticks, 80) <= rounding);
  }
}

TEST("positions and velocities stay at a change of stiffness, and the force follows it") {
  for (const bool reduced : {false, true}) {
    Scene scene = reduced ? reduced_scene() : needle_scene("implicit-euler");
    scene.needle.reset();
    scene.probe = Probe{.size = {0.004, 0.004}};
    scene.drive = Drive{.speed = 0.02, .depth = 0.0005};
    Simulation soft(scene);
    Simulation firm(with_factor(scene, 3.0));
    firm.prepare_to_continue(soft);
    run(soft, 500);  // at rest
    firm.continue_from(soft);
    const double moved = (firm.node_positions() - soft.node_positions()).cwiseAbs().maxCoeff();
    CHECK(moved <= (reduced ? 1e-12 : 0.0));  // modes of equally stiffer tissue span the same
    CHECK(firm.time() == soft.time());
    const double before = soft.tool().forces.total;
    CHECK(before > 0.01);
    run(firm, 50);
    // The tissue is linear in its modulus: at the same displacement, three times the force.
    CHECK_NEAR(firm.tool().forces.total / before, 3.0, 3e-6);
  }
}

TEST(
    "tissue that has relaxed keeps its strains: three times the stiffness, three times the force") {
  const Scene scene = relaxing_scene(false);
  Simulation soft(scene);
  Simulation firm(with_factor(scene, 3.0));
  Simulation same(scene);
  firm.prepare_to_continue(soft);
  same.prepare_to_continue(soft);
  run(soft, 120);  // the probe rests since 50 ms, and the tissue relaxes
  firm.continue_from(soft);
  same.continue_from(soft);
  run(firm, 100);
  run(same, 100);
  // A tissue of one scale of stiffness, quasi-static: displacements do not depend on it.
  CHECK_NEAR(firm.tool().forces.total / same.tool().forces.total, 3.0, 0.01);
}

TEST("a run goes on where the firmer tissue needs another scheme and other vectors") {
  for (const Drive::Kind kind : {Drive::Kind::trajectory, Drive::Kind::recorded}) {
    Scene scene = needle_scene("auto");
    scene.drive->kind = kind;
    Simulation soft(scene);
    Simulation firm(with_factor(scene, 100.0));
    REQUIRE(soft.plan().integrator != firm.plan().integrator);
    firm.prepare_to_continue(soft);
    soft.move_handle(0.001, 0.0);
    firm.move_handle(0.001, 0.0);
    run(soft, 50);
    const double before = soft.tool().place;
    CHECK(before > 0.0);
    firm.continue_from(soft);
    CHECK(firm.tool().place == before);
    CHECK(firm.tool().velocity == soft.tool().velocity);
    CHECK((firm.node_positions() - soft.node_positions()).cwiseAbs().maxCoeff() == 0.0);
    run(firm, 100);
  }
}

TEST("a state that does not fit is refused") {
  Simulation simulation(needle_scene("implicit-euler"));
  Simulation other_tick([] {
    Scene scene = needle_scene("implicit-euler");
    scene.simulation.step = 2e-3;
    return scene;
  }());
  CHECK_THROWS(other_tick.prepare_to_continue(simulation), "the tick");
  Simulation finer(reduced_scene());
  CHECK_THROWS(finer.prepare_to_continue(simulation), "the nodes");
  Simulation probe([] {
    Scene scene = needle_scene("implicit-euler");
    scene.needle.reset();
    scene.probe = Probe{.size = {0.004, 0.004}};
    return scene;
  }());
  CHECK_THROWS(probe.prepare_to_continue(simulation), "the tool");
  Simulation single(needle_scene("implicit-euler", Precision::single_precision));
  CHECK_THROWS(single.prepare_to_continue(simulation), "the precision");
}

TEST("a simulation refuses a scene whose materials change, which needs a subject") {
  Scene scene = needle_scene("implicit-euler");
  scene.materials[1].changes = {{.time = 0.1, .youngs_modulus = 1e5}};
  CHECK_THROWS(Simulation{scene}, "material.firm.change");
}

}  // namespace PALPATE_FILE
