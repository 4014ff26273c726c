// SPDX-License-Identifier: MIT

#include <array>
#include <memory>
#include <vector>

#include "model/stepping/simulation.hpp"
#include "tests/allocation_count.hpp"
#include "tests/check.hpp"
#include "tests/model/sample_scenes.hpp"

namespace PALPATE_FILE {

using namespace palpate;

/// Runs `ticks` ticks with all kinds of sampling and checks that they succeed without allocation.
void check_no_allocation(const Scene& scene, int ticks) {
  check::row = scene.simulation.integrator;
  Simulation simulation(scene);
  std::vector<double> row(simulation.columns().size());
  Eigen::VectorXd q(simulation.problem().dof());
  Eigen::VectorXd v(simulation.problem().dof());
  NodeVectors nodes = simulation.node_positions();
  const long before = check::allocations;
  StepStatus status = StepStatus::ok;
  for (int n = 0; n < ticks && status == StepStatus::ok; ++n) {
    status = simulation.tick();
    simulation.sample(row);
    simulation.coordinates(q);
    simulation.velocities(v);
    simulation.node_positions(nodes);
    (void)simulation.energy();
    (void)simulation.zero_length_springs();
  }
  const long after = check::allocations;
  CHECK(status == StepStatus::ok);
  CHECK(after == before);
}

/// Number of allocations of `ticks` ticks alone, which may diverge.
long allocations_of(Simulation&& simulation, int ticks) {
  const long before = check::allocations;
  for (int n = 0; n < ticks; ++n) { (void)simulation.tick(); }
  return check::allocations - before;
}

constexpr std::array precisions{Precision::double_precision, Precision::single_precision};

TEST("the counter counts every way to allocate, and one allocation inside a tick loop") {
  const long before = check::allocations;
  int* volatile one = new int(1);
  delete one;
  void* volatile block = std::malloc(64);
  block = std::realloc(block, 128);
  std::free(block);
  auto many = std::make_unique<std::vector<double>>(100);
  double* volatile data = many->data();
  (void)data;
  Eigen::VectorXd vector = Eigen::VectorXd::Constant(50, 1.0);
  double* volatile values = vector.data();
  (void)values;
  CHECK(check::allocations - before >= 6);
  Simulation simulation(moving_scene("velocity-verlet"));
  const long built = check::allocations;
  for (int n = 0; n < 10; ++n) {
    (void)simulation.tick();
    double* volatile leak_check = n == 5 ? new double(1.0) : nullptr;
    delete leak_check;
  }
  CHECK(check::allocations == built + 1);
}

TEST("no scheme allocates in a tick, in either precision, with or without dampers") {
  for (const IntegratorInfo* scheme : integrators()) {
    for (const Precision precision : precisions) {
      check_no_allocation(moving_scene(scheme->name, precision), 50);
    }
    Scene undamped = moving_scene(scheme->name);
    undamped.tissue.lattice.viscosity = 0.0;
    undamped.simulation.substeps = 4;
    check_no_allocation(undamped, 20);
  }
  CHECK(allocations_of(Simulation(moving_scene("velocity-verlet"), false), 20) == 0);
}

TEST("the printed form and the oscillator allocate nothing either") {
  Scene printed = moving_scene("euler-cromer");
  printed.simulation.printed = {.direction = true, .half_force = true, .lagged_velocity = true};
  check_no_allocation(printed, 20);
  for (const IntegratorInfo* scheme : integrators()) {
    Scene scene;
    scene.simulation = {.duration = 1.0, .step = 1e-2, .integrator = std::string(scheme->name)};
    scene.tissue.source = Source::oscillator;
    scene.tissue.oscillator.drive_amplitude = 1.0;
    scene.tissue.oscillator.drive_frequency = 2.0;
    check_no_allocation(scene, 50);
  }
}

TEST("a diverging run allocates nothing") {
  for (const char* name : {"velocity-verlet", "implicit-midpoint", "rk4", "leapfrog"}) {
    Scene scene = moving_scene(name);
    scene.simulation.step = 1.0;
    scene.simulation.duration = 100.0;
    scene.simulation.substeps = 1;
    CHECK(allocations_of(Simulation(scene), 100) == 0);
  }
}

TEST("a whole insertion allocates nothing: contact, punctures, loss of resistance, withdrawal") {
  for (const char* scheme : {"euler-cromer", "velocity-verlet", "rk4", "implicit-euler"}) {
    for (const Precision precision : precisions) {
      Scene scene = layered_scene();
      scene.syringe = Syringe{};
      scene.drive->depth = 0.0125;
      scene.drive->hold = 0.01;
      scene.drive->withdraw_speed = 0.04;
      scene.simulation = {
          .duration = 1.1, .step = 1e-3, .integrator = scheme, .precision = precision};
      check_no_allocation(scene, 1100);
    }
  }
}

TEST("going on from the state of another simulation allocates nothing") {
  Scene far = layered_scene();
  far.tissue.block = {.nodes = {7, 7}, .spacing = 0.004, .connectivity = 26};
  far.simulation = {.duration = 0.5,
                    .step = 1e-3,
                    .integrator = "implicit-euler",
                    .near_radius = 0.004,
                    .far_modes = 12};
  Scene relaxing = layered_scene();
  relaxing.simulation = {.duration = 0.5, .step = 1e-3, .integrator = "implicit-euler"};
  for (Material& material : relaxing.materials) {
    material.poissons_ratio = 0.4;
    material.relaxation = {{.share = 0.4, .time = 0.05}};
  }
  Scene sleeping = layered_scene();
  sleeping.simulation = {
      .duration = 0.5, .step = 1e-3, .integrator = "euler-cromer", .sleep_force = 1e-3};
  for (const Scene& scene : {far, relaxing, sleeping, moving_scene("leapfrog")}) {
    Scene firmer = scene;
    for (Material& material : firmer.materials) { material.youngs_modulus *= 2.0; }
    Simulation before(scene);
    Simulation after(firmer);
    after.prepare_to_continue(before);
    for (int n = 0; n < 200; ++n) { CHECK(before.tick() == StepStatus::ok); }
    const long allocations = check::allocations;
    after.continue_from(before);
    const StepStatus status = after.tick();
    CHECK(check::allocations == allocations);
    CHECK(status == StepStatus::ok);
  }
}

TEST("a lattice takes less than 200 bytes a node, while it is loaded too, and reports its memory") {
  constexpr int n = 60;
  for (const bool with_needle : {false, true}) {
    Scene scene;
    scene.simulation = {
        .duration = 0.01, .step = 1e-3, .substeps = 1, .integrator = "euler-cromer"};
    if (with_needle) {
      scene.needle = Needle{};
      scene.drive = Drive{};
      scene.simulation.precision = Precision::single_precision;
      scene.simulation.sleep_force = 1e-3;
    }
    scene.tissue.source = Source::lattice;
    scene.tissue.lattice = {.nodes = {n, n, n},
                            .weights = with_needle ? LatticeWeights::cell : LatticeWeights::uniform,
                            .material = "soft",
                            .viscosity = 0.05};
    scene.materials = tool_materials();
    const long before = check::held_bytes;
    check::most_held_bytes = before;
    const Simulation simulation(scene);
    const auto held = static_cast<double>(check::held_bytes - before);
    const auto most = static_cast<double>(check::most_held_bytes - before);
    constexpr double nodes = n * n * n;
    CHECK(simulation.plan().lattice);
    CHECK(most / nodes < 200.0);
    CHECK_NEAR(static_cast<double>(simulation.memory_bytes()), held, 0.02 * held);
  }
}

TEST("a needle in a block with a far field allocates nothing") {
  for (const Precision precision : precisions) {
    Scene scene = layered_scene();
    scene.tissue.block.nodes = {9, 9};
    scene.simulation = {.duration = 0.5,
                        .step = 1e-3,
                        .integrator = "implicit-euler",
                        .precision = precision,
                        .near_radius = scene.tissue.block.spacing,
                        .far_modes = 10};
    CHECK(Simulation(scene).plan().far != nullptr);
    check_no_allocation(scene, 500);
    scene.needle.reset();
    scene.drive.reset();
    scene.loads = {{.nodes = {9 * 4 + 4}, .force = {0.0, 0.0, 1e-3}}};
    for (const std::string integrator : {"velocity-verlet", "rk4", "leapfrog"}) {
      scene.simulation.integrator = integrator;
      CHECK(Simulation(scene).plan().far != nullptr);
      check_no_allocation(scene, 100);
    }
  }
}

TEST("a tool under an applied force and a probe allocate nothing") {
  for (const bool probe : {false, true}) {
    Scene scene = layered_scene();
    if (probe) {
      scene.needle.reset();
      scene.probe = Probe{.size = {0.004, 0.004}};
    }
    scene.drive = Drive{.kind = Drive::Kind::force, .force = 0.3, .rise = 0.2};
    scene.simulation = {.duration = 1.0, .step = 1e-3};
    check_no_allocation(scene, 500);
    if (!probe) { continue; }
    scene.probe->path = {{0.0, -0.001, 0.0}, {1.0, 0.001, 0.0005}};
    for (const char* integrator : {"velocity-verlet", "implicit-euler"}) {
      scene.simulation.integrator = integrator;
      check_no_allocation(scene, 500);
    }
  }
}

}  // namespace PALPATE_FILE
