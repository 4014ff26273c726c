// SPDX-License-Identifier: MIT
#pragma once
/// Faults that are planted in a candidate, to show that the checks detect them.

#include <cstddef>
#include <limits>

#include "validation/roll_out.hpp"

namespace palpate {

// Those of springs and masses change both the network, which may be empty, and the oscillator.

inline constexpr double quiet_nan = std::numeric_limits<double>::quiet_NaN();

inline Mutation stiffer() {
  return {.name = "stiffness +1 %", .model = [](Scene& scene, SpringNetwork& network) {
            network.springs.change_each([](Spring& spring) { spring.stiffness *= 1.01; });
            scene.tissue.oscillator.stiffness *= 1.01;
          }};
}

inline Mutation lighter() {
  return {.name = "mass -1 %", .model = [](Scene& scene, SpringNetwork& network) {
            network.mass *= 0.99;
            scene.tissue.oscillator.mass *= 0.99;
          }};
}

inline Mutation reversed_damping() {
  return {.name = "damping of the wrong sign", .model = [](Scene& scene, SpringNetwork& network) {
            network.springs.change_each([](Spring& spring) { spring.viscosity *= -1.0; });
            scene.tissue.oscillator.viscosity *= -1.0;
          }};
}

inline Mutation missing_spring() {
  return {
      .name = "one spring missing", .model = [](Scene&, SpringNetwork& network) {
        if (network.springs.empty()) { return; }
        const auto middle = static_cast<std::ptrdiff_t>(network.springs.size() / 2);
        network.springs.edit([&](std::vector<Spring>& all) { all.erase(all.begin() + middle); });
      }};
}

inline Mutation double_steps() { return {.name = "every step taken twice", .step_twice = true}; }

inline Mutation not_a_number() {
  return {.name = "NaN in one coordinate", .trace = [](Trace& motion) {
            motion.position(motion.position.rows() / 2, motion.position.cols() / 2) = quiet_nan;
          }};
}

inline Mutation late_frames() {
  return {.name = "frames one sample late", .trace = [](Trace& motion) {
            for (Eigen::MatrixXd* frames : {&motion.position, &motion.velocity}) {
              for (Eigen::Index n = frames->cols() - 1; n > 0; --n) {
                frames->col(n) = frames->col(n - 1).eval();
              }
            }
          }};
}

inline Mutation harder_to_cut() {
  return {.name = "cutting force +1 %", .model = [](Scene& scene, SpringNetwork&) {
            for (Material& material : scene.materials) { material.cutting_force *= 1.01; }
          }};
}

inline Mutation delayed_loop() { return {.name = "one more tick of delay", .loop_delay = 1}; }

}  // namespace palpate
