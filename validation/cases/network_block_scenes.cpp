// SPDX-License-Identifier: MIT
#include <cmath>

#include "model/dynamics/network_builder.hpp"
#include "validation/cases/network_blocks.hpp"

namespace palpate::networks {

BlockStudy cube_study(bool quick) {
  BlockStudy study{.what = "the cube"};
  study.shape = {{10, 10, 10}, 0.01, 26};
  study.network = uniform_lattice(study.shape, 50.0, 0.05, 1e-3);
  hold(study.network, Face::z_min);
  study.probe = 955;
  study.scene = scene_of("rk4", 1e-3, 0.1);
  study.scene.loads = {{.nodes = {study.probe}, .force = {0.0, 0.0, 0.1}}};
  study.settings.rungs = quick ? 2 : 4;
  study.settings.tolerance.relative = 1e-11;
  study.implicit_rungs = quick ? 0 : 2;
  return study;
}

namespace {

/// Published order of magnitude; ligaments and dura a hundredth of it, so that an explicit step of
/// some ten microseconds is stable.
std::vector<Material> layer_materials() {
  const auto made = [](const char* name, double youngs_modulus, double density) {
    return Material{
        .name = name, .youngs_modulus = youngs_modulus, .density = density, .damping_ratio = 0.5};
  };
  return {made("skin", 60e3, 1100.0),         made("fat", 5e3, 950.0),
          made("supraspinous", 80e3, 1130.0), made("interspinous", 100e3, 1130.0),
          made("flavum", 150e3, 1130.0),      made("epidural", 2e3, 950.0),
          made("dura", 122e3, 1174.0)};
}

}  // namespace

BlockStudy seven_layer_study(bool quick) {
  const int side = quick ? 4 : 5;
  Scene scene;
  scene.tissue.source = Source::layers;
  scene.tissue.block = {.nodes = {side, side}, .spacing = 2e-3};
  scene.materials = layer_materials();
  scene.tissue.layers = {{"skin", "skin", 0.002},
                         {"subcutaneous fat", "fat", 0.0048},
                         {"supraspinous ligament", "supraspinous", 0.003},
                         {"interspinous ligament", "interspinous", 0.0261},
                         {"ligamentum flavum", "flavum", 0.0034},
                         {"epidural space", "epidural", 0.006},
                         {"dura", "dura", 0.0007}};
  BlockStudy study{.what = "the seven layers"};
  study.network = build_network(scene);
  const int planes = static_cast<int>(study.network.node_count()) / (side * side);
  study.shape = {{side, side, planes}, 2e-3, 26};
  study.probe = study.shape.index(side / 2, side / 2, 0);
  study.scene = scene_of("rk4", 1e-3, quick ? 0.012 : 0.03);
  study.scene.loads = {{.nodes = {study.probe},
                        .force = {0.0, 0.0, 0.03},
                        .end = quick ? 0.01 : 0.02,
                        .profile = Profile::half_sine}};
  study.settings.rungs = quick ? 2 : 4;
  study.settings.tolerance.relative = 1e-13;
  study.implicit_substeps = 4;
  study.implicit_rungs = quick ? 0 : 2;
  return study;
}

BlockStudy heterogeneous_study(bool quick) {
  const int side = quick ? 6 : 8;
  const Block block{.nodes = {side, side, side}};
  BlockStudy study{.shape = block.shape(), .what = "the heterogeneous block"};
  study.network = block_network(block);
  Random random(51);
  for (double& mass : study.network.mass) { mass *= random(0.6, 1.6); }
  study.network.springs.change_each([&](Spring& s) {
    s.stiffness *= std::pow(10.0, random(-0.7, 0.7));
    const double a = study.network.mass(s.a);
    const double b = study.network.mass(s.b);
    s.viscosity = 2.0 * random(0.1, 0.5) * std::sqrt(s.stiffness * a * b / (a + b));
  });
  hold(study.network, Face::z_max);
  study.probe = study.shape.index(side / 2, side / 2, 0);
  study.scene = scene_of("rk4", 1e-3, quick ? 0.03 : 0.06);
  study.scene.loads = {{.face = Face::z_min,
                        .force = {1e-3, 0.0, 3e-3},
                        .end = quick ? 0.02 : 0.04,
                        .profile = Profile::half_sine}};
  study.settings.rungs = quick ? 2 : 4;
  study.settings.tolerance.relative = 1e-11;
  study.implicit_substeps = 2;
  return study;
}

}  // namespace palpate::networks
