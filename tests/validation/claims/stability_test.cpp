// SPDX-License-Identifier: MIT

#include "tests/validation/planted_faults.hpp"

namespace PALPATE_FILE {

using namespace palpate;

#ifndef PALPATE_SANITIZED  // there the faults below execute the same code
TEST("without a fault every case of stability passes") {
  for (const Case& one : select_cases(all_cases(), {}, true)) {
    if (one.name.starts_with("stability/")) { check_green(one.name); }
  }
}
#endif

TEST("every fault planted in a run fails the cases of stability that measure its effect") {
  const Mutation nan_energy{.name = "NaN in the energy", .trace = [](Trace& motion) {
                              if (motion.find("energy_j") == nullptr) { return; }
                              for (double& energy : motion.values("energy_j")) {
                                energy = quiet_nan;
                              }
                            }};
  const Mutation one_nan{.name = "one NaN in the energy", .trace = [](Trace& motion) {
                           if (motion.find("energy_j") == nullptr) { return; }
                           motion.values("energy_j")[motion.rows() / 2] = quiet_nan;
                         }};
  const Mutation silent{.name = "divergence not reported",
                        .trace = [](Trace& motion) { motion.diverged = false; }};
  const Mutation late{.name = "divergence reported a tick late",
                      .trace = [](Trace& motion) { motion.diverged_at *= 2.0; }};
  const Mutation creeping{.name = "energy that increases by a part in ten million",
                          .trace = [](Trace& motion) {
                            const auto last = static_cast<double>(motion.position.cols() - 1);
                            for (Eigen::Index n = 0; n < motion.position.cols(); ++n) {
                              const double gain = 1.0 + 1e-7 * static_cast<double>(n) / last;
                              motion.position.col(n) *= gain;
                              if (motion.velocity.cols() > n) { motion.velocity.col(n) *= gain; }
                            }
                          }};
  check_red(
      "stability/",
      {{reversed_damping(),
        {"blow-up/euler", "blow-up/euler-cromer", "blow-up/leapfrog", "blow-up/rk4",
         "map/velocity-verlet", "map/implicit-midpoint", "inverted", "step-jitter"}},
       {double_steps(),
        {"blow-up/euler-cromer", "blow-up/feynman-newton", "blow-up/velocity-verlet", "map/euler",
         "map/leapfrog", "drift/oscillator", "zero-length"}},
       {stiffer(),
        {"blow-up/euler-cromer", "blow-up/leapfrog", "blow-up/rk4", "map/euler-cromer", "map/rk4",
         "drift/oscillator", "zero-length", "spectral-bounds"}},
       {lighter(), {"blow-up/velocity-verlet", "map/feynman-newton"}},
       {not_a_number(), {"blow-up/leapfrog", "zero-length", "huge-force", "denormals"}},
       {nan_energy,
        {"stiffness-contrast", "mass-ratio", "inverted", "drift/oscillator", "drift/network"}},
       {one_nan, {"stiffness-contrast", "mass-ratio", "inverted", "drift/oscillator"}},
       {silent, {"nan-injection"}},
       {late, {"nan-injection"}},
       {creeping, {"drift/oscillator"}}});
}

}  // namespace PALPATE_FILE
