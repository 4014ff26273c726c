// SPDX-License-Identifier: MIT
#pragma once
/// Synthetic insertions and an analytic forward model for tests of the calibration.

#include <cmath>
#include <vector>

#include "validation/calibration/calibration.hpp"

namespace palpate::calibration {

/// Insertion at 1 mm/s from `begin`: constant pressure, zero after a depth of `loss` [m]; force
/// linear in depth, 2 N + 100 N/m.
inline Recording straight_insertion(double level = 60e3, double loss = 20e-3,
                                    double floor = 2000.0) {
  Recording recording{.name = "made-up", .technique = "continuous", .sample_rate = 100.0};
  constexpr double begin = 5e-3;
  constexpr double speed = 1e-3;
  for (int n = 0; n <= 2500; ++n) {
    const double time = 0.01 * n;
    const double depth = std::fmin(begin + speed * time, loss + 0.5e-3);
    recording.time.push_back(time);
    recording.depth.push_back(depth);
    recording.pressure.push_back(depth < loss ? level : floor);
    recording.force.push_back(depth < loss ? 2.0 + 100.0 * depth : 0.0);
  }
  return recording;
}

/// Scene with layers whose values a test can set. It is never simulated.
inline Scene three_layers() {
  Scene scene;
  scene.tissue.source = Source::layers;
  scene.materials = {
      {.name = "firm-fat", .youngs_modulus = 9e3, .cutting_force = 0.4, .friction = 20.0},
      {.name = "ligament", .youngs_modulus = 1e7, .cutting_force = 5.0, .friction = 80.0},
      {.name = "epidural-space", .youngs_modulus = 2e3}};
  scene.tissue.layers = {{"fat", "firm-fat", 0.010},
                         {"ligament", "ligament", 0.020},
                         {"space", "epidural-space", 0.006}};
  scene.needle = Needle{};
  scene.drive = Drive{.speed = 0.005, .depth = 0.033};
  scene.syringe = Syringe{};
  scene.simulation.duration = 8.0;
  return scene;
}

/// Analytic forward model instead of the simulation: peak from the thumb, plateau and drop from the
/// syringe, force from the cutting force of the ligament, depth from the layers.
inline ObservedInsertion lawful(const Scene& scene) {
  const Syringe& s = *scene.syringe;
  ObservedInsertion seen{
      .value = Observation::Constant(observable_count, scene.materials[1].cutting_force)};
  seen.value[index_of(Observable::pressure_peak)] = s.thumb_force / s.plunger_area;
  seen.value[index_of(Observable::plateau)] = s.thumb_flow * s.epidural_resistance;
  seen.value[index_of(Observable::drop_time)] = 2.197 * s.compliance * s.epidural_resistance;
  seen.value[index_of(Observable::depth_of_loss)] =
      scene.tissue.layers[0].thickness + scene.tissue.layers[1].thickness;
  return seen;
}

/// Forward model of the scene without a simulation.
inline Forward lawful_forward(int jobs = 1) {
  return {three_layers(), parameters_of(three_layers()), jobs, nullptr, lawful};
}

inline Scene with_thumb_force(double force) {
  Scene scene = three_layers();
  scene.syringe->thumb_force = force;
  return scene;
}

/// Means computed with the analytic model, each with an independent relative uncertainty [1].
inline Pooled lawful_data(const Scene& truth, double relative) {
  Pooled data{.mean = lawful(truth).value, .subjects = 1};
  data.covariance = (relative * data.mean).cwiseAbs2().asDiagonal();
  data.count.assign(static_cast<std::size_t>(observable_count), 1);
  return data;
}

}  // namespace palpate::calibration
