// SPDX-License-Identifier: MIT
#pragma once
/// Random networks for tests. The same seed gives the same network on every machine.

#include <cmath>
#include <cstdint>
#include <string>

#include "model/problem/scene.hpp"
#include "model/problem/spring_network.hpp"
#include "validation/random.hpp"

namespace palpate {

struct RandomNetwork {
  int nodes = 12;
  int springs = 40;
  int fixed = 2;
  double decades = 2.0;    ///< range of stiffness, viscosity and mass in decades
  double stretch = 0.2;    ///< largest relative difference between rest lengths and distances [1]
  double viscosity = 0.1;  ///< largest viscosity [N s/m]; 0: undamped
};

/// Random connected network: every node has a spring to an earlier node; spring ends are in random
/// order.
inline SpringNetwork random_network(std::uint64_t seed, const RandomNetwork& wanted = {}) {
  Random random(seed);
  const auto decades = [&](double largest) {
    return largest * std::pow(10.0, -random(0.0, wanted.decades));
  };
  SpringNetwork network;
  network.rest_position =
      NodeVectors::NullaryExpr(3, wanted.nodes, [&] { return random(-0.01, 0.01); });
  network.initial_velocity =
      NodeVectors::NullaryExpr(3, wanted.nodes, [&] { return random(-0.1, 0.1); });
  network.mass = Eigen::VectorXd::NullaryExpr(wanted.nodes, [&] { return decades(1e-2); });
  network.fixed.assign(static_cast<std::size_t>(wanted.nodes), 0);
  for (int n = 0; n < wanted.fixed; ++n) { network.fixed[static_cast<std::size_t>(3 * n)] = 1; }
  for (int n = 0; n < wanted.springs; ++n) {
    const int b = n + 1 < wanted.nodes ? n + 1 : static_cast<int>(random(1.0, wanted.nodes));
    const int a = static_cast<int>(random(0.0, b));
    const double length = (network.rest_position.col(b) - network.rest_position.col(a)).norm();
    const bool turned = random(0.0, 1.0) < 0.5;
    network.springs.push_back({turned ? b : a, turned ? a : b, decades(1e3),
                               wanted.viscosity > 0.0 ? decades(wanted.viscosity) : 0.0,
                               length * (1.0 + random(-wanted.stretch, wanted.stretch))});
  }
  return network;
}

inline Lattice uniform_cube(int nodes) {
  return {.nodes = {nodes, nodes, nodes},
          .spacing = 0.01,
          .connectivity = 26,
          .weights = LatticeWeights::uniform,
          .stiffness = 50.0,
          .viscosity = 0.05,
          .node_mass = 1e-3};
}

// Small scene that uses every feature of a tick: dampers, switched loads, weight, records.

inline Scene moving_scene(std::string_view integrator, Precision precision = {}) {
  Scene scene;
  scene.simulation = {
      .duration = 1.0, .step = 1e-3, .integrator = std::string(integrator), .precision = precision};
  scene.tissue.gravity = {0.0, 0.0, 9.81};
  scene.tissue.lattice = {.nodes = {3, 3, 4},
                          .spacing = 0.005,
                          .weights = LatticeWeights::uniform,
                          .stiffness = 50.0,
                          .viscosity = 0.05,
                          .node_mass = 1e-3};
  Load push{.force = {0.0, 0.0, 0.01}, .start = 2e-3, .end = 10e-3, .profile = Profile::half_sine};
  push.face = Face::z_min;
  scene.loads = {push, {.nodes = {3}, .force = {1e-3, 0.0, 0.0}, .start = 5e-3}};
  scene.records = {
      {"top", 4, {RecordedQuantity::position, RecordedQuantity::velocity, RecordedQuantity::force}},
      {"near", Eigen::Vector3d(0.004, 0.004, 0.006), {RecordedQuantity::position}}};
  if (integrator == "euler") { scene.simulation.substeps = 20; }
  return scene;
}

// Small scenes with a needle for tests of tools.

inline std::vector<Material> tool_materials() {
  return {{.name = "soft",
           .youngs_modulus = 100e3,
           .damping_ratio = 0.5,
           .cutting_force = 0.1,
           .friction = 2.0,
           .role = TissueRole::tissue},
          {.name = "firm",
           .youngs_modulus = 200e3,
           .damping_ratio = 0.5,
           .cutting_force = 0.15,
           .friction = 5.0,
           .role = TissueRole::tissue},
          {.name = "loose",
           .youngs_modulus = 50e3,
           .damping_ratio = 0.5,
           .role = TissueRole::epidural_space}};
}

inline std::vector<Layer> tool_layers() {
  return {{"skin", "soft", 0.004}, {"ligament", "firm", 0.006}, {"epidural space", "loose", 0.006}};
}

/// Columns of three layers, 16 mm deep and 8 mm wide.
inline Scene layered_scene(double spacing = 0.004) {
  Scene scene;
  scene.tissue.source = Source::layers;
  const int across = static_cast<int>(std::lround(0.008 / spacing)) + 1;
  scene.tissue.block = {.nodes = {across, across}, .spacing = spacing, .connectivity = 26};
  scene.materials = tool_materials();
  scene.tissue.layers = tool_layers();
  scene.needle = Needle{};
  scene.drive = Drive{.speed = 0.02};
  return scene;
}

/// Chain of ten equal springs along z; the last node is fixed.
inline Scene chain_scene(double stiffness = 500.0, double node_mass = 2e-4) {
  constexpr int nodes = 11;
  constexpr double spacing = 0.002;
  Scene scene;
  scene.tissue.source = Source::network;
  SpringNetwork& network = scene.tissue.network;
  network.rest_position.setZero(3, nodes);
  network.mass.setConstant(nodes, node_mass);
  network.fixed.assign(nodes, 0);
  network.fixed.back() = 1;
  for (int i = 0; i < nodes; ++i) {
    network.rest_position(2, i) = i * spacing;
    if (i > 0) {
      network.springs.push_back(
          {i - 1, i, stiffness, std::sqrt(stiffness * node_mass / 2.0), spacing});
    }
  }
  scene.materials = tool_materials();
  scene.tissue.layers = tool_layers();
  scene.needle = Needle{};
  scene.drive = Drive{.speed = 0.02};
  return scene;
}

}  // namespace palpate
