// SPDX-License-Identifier: MIT
#pragma once
/// A small scene that uses everything a tick can do: dampers, loads that switch, weight, records.

#include <string>

#include "model/dynamics/scene.hpp"

namespace palpate {

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

}  // namespace palpate
