// SPDX-License-Identifier: MIT
#pragma once
/// Short insertions into the layers of tests/model/sample_scenes.hpp.

#include "tests/model/sample_scenes.hpp"

namespace palpate {

inline Scene insertion_scene(double duration, double step = 1e-3, double speed = 0.02) {
  Scene scene = layered_scene();
  scene.drive->speed = speed;
  scene.simulation = {.duration = duration, .step = step};
  return scene;
}

/// The needle is driven by a hand through a haptic device.
inline Scene hand_scene(double duration, double step, double speed = 0.02) {
  Scene scene = insertion_scene(duration, step);
  scene.drive = Drive{.kind = Drive::Kind::falcon, .speed = speed};
  return scene;
}

inline Scene syringe_scene(double step = 1e-3) {
  Scene scene = insertion_scene(0.3, step, 0.05);
  scene.syringe = Syringe{};
  return scene;
}

}  // namespace palpate
