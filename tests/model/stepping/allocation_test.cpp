// SPDX-License-Identifier: MIT

#include <cstdio>
#include <memory>
#include <vector>

#include "model/stepping/simulation.hpp"
#include "tests/allocation_count.hpp"
#include "tests/check.hpp"
#include "tests/model/sample_scenes.hpp"

namespace {

using namespace palpate;

/// Number of allocations of `ticks` ticks with all kinds of sampling; -1 if the run diverged.
long allocations_of(const Scene& scene, int ticks) {
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
  return status == StepStatus::ok ? check::allocations - before : -1;
}

TEST("the counter sees every way to allocate") {
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
}

TEST("the counter sees one allocation inside a tick loop") {
  const long before = check::allocations;
  Simulation simulation(moving_scene("velocity-verlet"));
  const long built = check::allocations;
  CHECK(built > before);
  for (int n = 0; n < 10; ++n) {
    (void)simulation.tick();
    double* volatile leak_check = n == 5 ? new double(1.0) : nullptr;
    delete leak_check;
  }
  CHECK_NEAR(static_cast<double>(check::allocations - built), 1.0, 0.0);
}

TEST("no scheme allocates in a tick, in either precision") {
  for (const IntegratorInfo* scheme : integrators()) {
    for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
      const long count = allocations_of(moving_scene(scheme->name, precision), 50);
      if (count != 0) { std::printf("  %s: %ld allocations\n", scheme->name.data(), count); }
      CHECK_NEAR(static_cast<double>(count), 0.0, 0.0);
    }
  }
}

TEST("no scheme allocates with undamped springs, zero-length springs or computed fixed pairs") {
  for (const IntegratorInfo* scheme : integrators()) {
    Scene scene = moving_scene(scheme->name);
    scene.tissue.lattice.viscosity = 0.0;
    scene.simulation.substeps = 4;
    CHECK_NEAR(static_cast<double>(allocations_of(scene, 20)), 0.0, 0.0);
  }
  Simulation all(moving_scene("velocity-verlet"), false);
  const long before = check::allocations;
  for (int n = 0; n < 20; ++n) { (void)all.tick(); }
  CHECK_NEAR(static_cast<double>(check::allocations - before), 0.0, 0.0);
}

TEST("the printed form and the oscillator allocate nothing either") {
  Scene printed = moving_scene("euler-cromer");
  printed.simulation.printed = {.direction = true, .half_force = true, .lagged_velocity = true};
  CHECK_NEAR(static_cast<double>(allocations_of(printed, 20)), 0.0, 0.0);
  for (const IntegratorInfo* scheme : integrators()) {
    Scene scene;
    scene.simulation = {.duration = 1.0, .step = 1e-2, .integrator = std::string(scheme->name)};
    scene.tissue.source = Source::oscillator;
    scene.tissue.oscillator.drive_amplitude = 1.0;
    scene.tissue.oscillator.drive_frequency = 2.0;
    CHECK_NEAR(static_cast<double>(allocations_of(scene, 50)), 0.0, 0.0);
  }
}

TEST("a diverging run allocates nothing") {
  Scene scene = moving_scene("velocity-verlet");
  scene.simulation.step = 1.0;
  scene.simulation.duration = 100.0;
  scene.simulation.substeps = 1;
  for (const char* name : {"velocity-verlet", "implicit-midpoint", "rk4", "leapfrog"}) {
    scene.simulation.integrator = name;
    Simulation simulation(scene);
    const long before = check::allocations;
    for (int n = 0; n < 100; ++n) { (void)simulation.tick(); }
    CHECK_NEAR(static_cast<double>(check::allocations - before), 0.0, 0.0);
  }
}

TEST("a whole insertion allocates nothing: contact, punctures, loss of resistance, withdrawal") {
  for (const char* scheme : {"euler-cromer", "velocity-verlet", "rk4", "implicit-euler"}) {
    for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
      Scene scene = layered_scene();
      scene.syringe = Syringe{};
      scene.drive->depth = 0.0125;
      scene.drive->hold = 0.01;
      scene.drive->withdraw_speed = 0.04;
      scene.simulation = {
          .duration = 1.1, .step = 1e-3, .integrator = scheme, .precision = precision};
      const long count = allocations_of(scene, 1100);
      if (count != 0) { std::printf("  %s: %ld allocations\n", scheme, count); }
      CHECK_NEAR(static_cast<double>(count), 0.0, 0.0);
    }
  }
}

TEST(
    "a lattice of many nodes takes less than 200 bytes a node, while it is loaded too, and says "
    "how much") {
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
  for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
    Scene scene = layered_scene();
    scene.tissue.block.nodes = {9, 9};
    scene.simulation = {.duration = 0.5,
                        .step = 1e-3,
                        .integrator = "implicit-euler",
                        .precision = precision,
                        .near_radius = scene.tissue.block.spacing,
                        .far_modes = 10};
    CHECK(Simulation(scene).plan().far != nullptr);
    CHECK_NEAR(static_cast<double>(allocations_of(scene, 500)), 0.0, 0.0);
    scene.needle.reset();
    scene.drive.reset();
    scene.loads = {{.nodes = {9 * 4 + 4}, .force = {0.0, 0.0, 1e-3}}};
    for (const std::string integrator : {"velocity-verlet", "rk4", "leapfrog"}) {
      scene.simulation.integrator = integrator;
      CHECK(Simulation(scene).plan().far != nullptr);
      CHECK_NEAR(static_cast<double>(allocations_of(scene, 100)), 0.0, 0.0);
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
    CHECK_NEAR(static_cast<double>(allocations_of(scene, 500)), 0.0, 0.0);
  }
}

}  // namespace
