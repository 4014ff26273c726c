// SPDX-License-Identifier: MIT
/// Pulls a column of springs with a force and compares its length at rest with Hooke's law.

#include <cmath>
#include <cstdio>

#include "device/falcon/kinematics.hpp"
#include "model/stepping/simulation.hpp"
#include "model/tissue/network_builder.hpp"
#include "model/tissue/scene_check.hpp"

int main() {
  palpate::Scene scene;
  scene.simulation.duration = 1.0;
  palpate::Lattice& lattice = scene.tissue.lattice;
  lattice.nodes = {2, 2, 3};
  lattice.connectivity = 6;
  lattice.weights = palpate::LatticeWeights::uniform;
  lattice.stiffness = 50.0;
  lattice.viscosity = 0.2;  // the slowest mode, 138 rad/s, decays with exp(-38 t)
  lattice.node_mass = 1e-3;
  scene.tissue.fixed = {palpate::Face::z_max};
  scene.loads.push_back({.face = palpate::Face::z_min, .force = {0.0, 0.0, -0.05}});

  const palpate::SpringNetwork network = palpate::build_network(scene);
  palpate::Simulation simulation(scene, network);
  while (simulation.ticks() < simulation.tick_count()) {
    if (simulation.tick() != palpate::StepStatus::ok) { return 1; }
  }
  // Memory that the library allocated is freed here, and the other way round.
  palpate::NodeVectors position = simulation.node_positions();
  position -= network.rest_position;

  constexpr double expected = -0.05 * 2.0 / 50.0;  // two springs in series [m]
  const double stretched = position(2, 0);
  if (!(std::abs(stretched - expected) <= 1e-9)) {  // Hooke's law; the motion is below 1e-16 m
    std::printf("the column is stretched by %.17g m instead of %.17g m\n", stretched, expected);
    return 1;
  }
  return 0;
}
