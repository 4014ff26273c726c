// SPDX-License-Identifier: MIT
#pragma once
/// Small scenes with a needle for the tests of tools.

#include <cmath>

#include "model/dynamics/scene.hpp"

namespace palpate {

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

/// Columns of three layers; 16 mm deep, 8 mm wide.
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

/// Ten equal springs in a row along z, the last node fixed.
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
