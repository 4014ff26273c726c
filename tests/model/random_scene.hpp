// SPDX-License-Identifier: MIT
#pragma once
/// Scenes whose features are on or off by chance: same seed, same scene, on every machine.

#include <array>
#include <string>

#include "model/stepping/integrator.hpp"
#include "tests/model/random_network.hpp"
#include "tests/model/tool_scenes.hpp"

namespace palpate {

/// What a scene can have or not.
struct SceneFeatures {
  bool damping = false;
  bool gravity = false;
  bool loads = false;
  bool records = false;
  bool side_faces = false;  ///< fixed, besides the bottom
  bool inclusion = false;
  bool needle = false;
  bool single = false;
  bool two_threads = false;

  static constexpr std::size_t count = 9;
  [[nodiscard]] std::array<bool, count> all() const {
    return {damping, gravity, loads, records, side_faces, inclusion, needle, single, two_threads};
  }
};

struct RandomScene {
  SceneFeatures features{};
  Scene scene{};
};

namespace random_scene_parts {

inline SceneFeatures features(Random& random) {
  const auto coin = [&] { return random(0.0, 1.0) < 0.5; };
  SceneFeatures chosen;
  for (bool* one : {&chosen.damping, &chosen.gravity, &chosen.loads, &chosen.records, &chosen.side_faces,
                    &chosen.inclusion, &chosen.needle, &chosen.single, &chosen.two_threads}) {
    *one = coin();
  }
  return chosen;
}

inline int whole(Random& random, int low, int high) {
  return static_cast<int>(std::floor(random(low, high + 1.0)));
}

inline void add_tissue(const SceneFeatures& features, Random& random, Scene& scene) {
  if (features.needle) {
    scene = layered_scene();
    scene.drive->speed = random(0.01, 0.04);
  } else {
    scene.materials = tool_materials();
    scene.tissue.lattice = {
        .nodes = {whole(random, 3, 9), whole(random, 3, 5), whole(random, 4, 5)},
        .spacing = 0.004,
        .connectivity = std::array{6, 18, 26}[static_cast<std::size_t>(whole(random, 0, 2))],
        .material = "soft"};
  }
  for (Material& material : scene.materials) {
    material.damping_ratio = features.damping ? random(0.1, 0.7) : 0.0;
  }
  scene.tissue.fixed = std::vector<Face>{Face::z_max};
  if (features.side_faces) {
    scene.tissue.fixed->insert(scene.tissue.fixed->end(), {Face::x_min, Face::x_max});
  }
  if (features.inclusion) {
    scene.tissue.inclusions = {
        {.centre = {0.002, 0.0, 0.006}, .size = {0.006, 0.006, 0.006}, .material = "firm"}};
  }
}

/// They take turns; two keep velocities of half steps, which no tool can be felt with.
inline std::string scheme_of(const SceneFeatures& features, std::uint64_t seed) {
  const auto schemes = integrators();
  const std::string name(schemes[seed % schemes.size()]->name);
  return features.needle && (name == "leapfrog" || name == "feynman-newton") ? "auto" : name;
}

}  // namespace random_scene_parts

inline RandomScene random_scene(std::uint64_t seed) {
  namespace parts = random_scene_parts;
  Random random(seed);
  RandomScene made{.features = parts::features(random)};
  const SceneFeatures& features = made.features;
  Scene& scene = made.scene;
  parts::add_tissue(features, random, scene);
  scene.simulation = {
      .duration = 0.03,
      .step = 1e-3,
      .integrator = parts::scheme_of(features, seed),
      .precision = features.single ? Precision::single_precision : Precision::double_precision,
      .threads = features.two_threads ? 2 : 1};
  if (!features.damping && scene.simulation.integrator == "euler") { scene.simulation.substeps = 50; }
  if (features.gravity) { scene.tissue.gravity = {random(-1.0, 1.0), 0.0, 9.81}; }
  if (features.loads) {
    scene.loads = {{.nodes = {parts::whole(random, 0, 8)},
                    .force = {random(-0.01, 0.01), 0.0, random(0.0, 0.02)},
                    .start = random(0.0, 0.01),
                    .end = random(0.015, 0.025),
                    .profile = Profile::half_sine}};
  }
  if (features.records) {
    scene.records = {{"somewhere",
                      parts::whole(random, 0, 20),
                      {RecordedQuantity::position, RecordedQuantity::velocity, RecordedQuantity::force}}};
  }
  return made;
}

}  // namespace palpate
