// SPDX-License-Identifier: MIT
#include "model/stepping/far_field_network.hpp"

#include <algorithm>

#include "model/dynamics/network_builder.hpp"
#include "model/stepping/simulation.hpp"
#include "tests/check.hpp"

namespace {

using namespace palpate;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// A cube held on one face and pulled in the middle of the other.
Scene pulled_cube(double near_radius, int far_modes) {
  Scene scene;
  scene.simulation = {.duration = 0.05,
                      .step = 1e-3,
                      .integrator = "rk4",
                      .near_radius = near_radius,
                      .far_modes = far_modes};
  scene.simulation.substeps = 1;
  scene.tissue.fixed = std::vector<Face>{Face::z_min};
  scene.tissue.lattice = {.nodes = {9, 9, 9},
                          .spacing = 0.01,
                          .connectivity = 26,
                          .weights = LatticeWeights::uniform,
                          .stiffness = 50.0,
                          .viscosity = 0.05,
                          .node_mass = 1e-3};
  scene.loads = {{.nodes = {(8 * 9 + 4) * 9 + 4}, .force = {0.0, 0.0, 0.1}}};
  return scene;
}

/// Of the pulled node: how far it goes from where it goes with every node stepped, over the furthest.
double error_of_far_field(const Scene& scene) {
  Scene all = scene;
  all.simulation.near_radius = 0.0;
  Simulation whole(all);
  Simulation reduced(scene);
  CHECK(reduced.plan().near.has_value() && !reduced.plan().integrator->implicit && !reduced.plan().lattice);
  const int node = scene.loads.front().nodes.front();
  const Vector3d rest = whole.node_positions().col(node);
  double peak = 0.0;
  double off = 0.0;
  while (whole.ticks() < whole.tick_count()) {
    CHECK(whole.tick() == StepStatus::ok && reduced.tick() == StepStatus::ok);
    const Vector3d there = whole.node_positions().col(node);
    peak = std::max(peak, (there - rest).norm());
    off = std::max(off, (reduced.node_positions().col(node) - there).norm());
  }
  return off / peak;
}

}  // namespace

TEST("with more modes what a load pulls at comes nearer, until what is not linear is left, which goes with the load") {
  double before = 1.0;
  for (const int modes : {3, 6, 12}) {
    const double error = error_of_far_field(pulled_cube(0.025, modes));
    CHECK(error < 0.2 * before);
    before = error;
  }
  Scene gentle = pulled_cube(0.025, 24);
  const double at_full_load = error_of_far_field(gentle);
  gentle.loads.front().force *= 0.1;
  CHECK_NEAR(error_of_far_field(gentle), 0.1 * at_full_load, 0.02 * at_full_load);
}

TEST("near is what lies within the radius of a pushed node, along every line") {
  const Simulation simulation(pulled_cube(0.02, 8));
  const NodeVectors rest = simulation.node_positions();
  const Vector3d middle = rest.col(pulled_cube(0.0, 1).loads.front().nodes.front());
  for (int node = 0; node < static_cast<int>(rest.cols()); ++node) {
    CHECK(simulation.plan().near->holds(node) == ((rest.col(node) - middle).norm() < 0.02 + 1e-9));
  }
}

TEST("a step that is stable for the whole tissue is stable with a far field") {
  for (const int modes : {1, 10, 100}) {
    Scene scene = pulled_cube(0.015, modes);
    scene.simulation.integrator = "velocity-verlet";
    scene.simulation.duration = 2.0;
    scene.simulation.step = 0.9 * Simulation(pulled_cube(0.0, 1)).plan().stable_step.at("velocity-verlet");
    Simulation simulation(scene);
    double most = 0.0;
    while (simulation.ticks() < simulation.tick_count()) {
      CHECK(simulation.tick() == StepStatus::ok);
      most = std::max(most, simulation.energy());
    }
    // What a load of 0.1 N brings in, over less than 2 mm.
    CHECK(most < 0.1 * 2e-3);
  }
}

TEST("gravity, printed equations, and tissue that nothing holds or pushes keep every node") {
  Scene heavy = pulled_cube(0.02, 8);
  heavy.tissue.gravity = {0.0, 0.0, 9.81};
  const Scene near_alone = pulled_cube(1.0, 8);
  Scene without_push = pulled_cube(0.02, 8);
  without_push.loads.clear();
  Scene floating = pulled_cube(0.02, 8);
  floating.tissue.fixed = std::vector<Face>{};
  Scene pulled_where_held = pulled_cube(0.02, 8);
  pulled_where_held.loads.front().nodes = {4};
  Scene printed = pulled_cube(0.02, 8);
  printed.simulation.integrator = "euler-cromer";
  printed.simulation.printed.half_force = true;
  for (const Scene& scene : {heavy, near_alone, without_push, floating, pulled_where_held, printed}) {
    const Simulation simulation(scene);
    CHECK(!simulation.plan().near);
    CHECK(std::ranges::any_of(simulation.plan().warnings, [](const std::string& w) {
      return w.starts_with("nothing is left to a far field: ");
    }));
  }
  CHECK(!Simulation(pulled_cube(0.02, 8), false).plan().near);
}

TEST("with a far field \"auto\" steps explicitly where few substeps do, and implicitly where it would take many") {
  Scene scene = pulled_cube(0.02, 8);
  scene.simulation.integrator = "auto";
  scene.simulation.substeps.reset();
  CHECK(!Simulation(scene).plan().integrator->implicit);
  scene.tissue.lattice.stiffness *= 1e6;
  CHECK(Simulation(scene).plan().integrator->implicit);
}

TEST("a far field that a push does not reach has no shapes and stays at rest") {
  const Scene scene = pulled_cube(0.02, 8);
  const auto made = make_problem(scene);
  const auto& problem = dynamic_cast<const NetworkProblem&>(*made);
  SpringNetwork walled = problem.network();
  for (int n = 0; n < 81; ++n) { walled.fixed[static_cast<std::size_t>(5 * 81 + n)] = 1; }
  const NetworkProblem beyond_a_wall(walled, problem.loads());
  FarFieldSetting setting{.near = {.near = std::vector<unsigned char>(729, 0), .box = {.first = {0, 0, 6}, .last = {8, 8, 8}}},
                          .pushes = pushes_of(scene, beyond_a_wall),
                          .modes = 8};
  std::fill(setting.near.near.begin() + 6 * 81, setting.near.near.end(), static_cast<unsigned char>(1));
  FarFieldNetwork<double> reduced(beyond_a_wall, setting);
  CHECK(reduced.dof() == 3 * 3 * 81);
  const VectorXd q = reduced.initial_position();
  CHECK_NEAR(reduced.moved(q, 3 * 81 + 40).norm(), 0.0, 0.0);
  VectorXd f(reduced.dof());
  reduced.force(0.0, 0.0, q, VectorXd::Zero(reduced.dof()), f);
  CHECK_NEAR(f.norm(), 0.1, 1e-12);
}

TEST("tissue that is held at a single node has no far field to answer at rest") {
  const Scene scene = pulled_cube(0.02, 8);
  const auto made = make_problem(scene);
  const auto& problem = dynamic_cast<const NetworkProblem&>(*made);
  SpringNetwork hung = problem.network();
  std::fill(hung.fixed.begin() + 1, hung.fixed.end(), static_cast<unsigned char>(0));
  const NetworkProblem turning(hung, problem.loads());
  const GradedLattice graded(turning, lattice_of(hung).value(), {.first = {2, 2, 6}, .last = {6, 6, 8}});
  CHECK_THROWS((void)GradedLattice::Statics(graded), "nothing holds the tissue");
}
