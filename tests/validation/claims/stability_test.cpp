// SPDX-License-Identifier: MIT
/// Tests that faults planted in the candidate fail the verdicts of group "stability".

#include <cmath>
#include <cstdio>
#include <limits>

#include "tests/validation/planted_faults.hpp"

namespace {

using namespace palpate;

/// Checks that the cases fail with the fault. The first test checks that they pass without it.
void check_fails(const Mutation& mutation, std::initializer_list<const char*> names) {
  for (const char* name : tried(std::span<const char* const>(names))) {
    check_status(name, &mutation, Status::fail);
  }
}

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

#ifndef PALPATE_SANITIZED  // there the faults below go through the same code
TEST("without a fault every case of the group passes") {
  for (const Case& one : select_cases(all_cases(), {}, true)) {
    if (!one.name.starts_with("stability/")) { continue; }
    check_status(one.name, nullptr, Status::pass);
  }
}
#endif

TEST("damping with the wrong sign is seen") {
  const Mutation fault{
      .name = "damping turned round", .model = [](Scene& scene, SpringNetwork& network) {
        network.springs.change_each([&](Spring& s) { s.viscosity = -s.viscosity; });
        scene.tissue.oscillator.viscosity = -scene.tissue.oscillator.viscosity;
      }};
  check_fails(fault, {"stability/blow-up/euler", "stability/blow-up/euler-cromer",
                      "stability/blow-up/leapfrog", "stability/blow-up/rk4",
                      "stability/map/velocity-verlet", "stability/map/implicit-midpoint",
                      "stability/inverted"});
}

TEST("a step used twice is seen") {
  const Mutation fault{.name = "step twice", .step_twice = true};
  check_fails(fault,
              {"stability/blow-up/euler-cromer", "stability/blow-up/feynman-newton",
               "stability/blow-up/velocity-verlet", "stability/map/euler", "stability/map/leapfrog",
               "stability/drift/oscillator", "stability/zero-length"});
}

TEST("one per cent of stiffness is seen") {
  const Mutation fault{.name = "stiffness +1 %", .model = [](Scene& scene, SpringNetwork& network) {
                         network.springs.change_each([&](Spring& s) { s.stiffness *= 1.01; });
                         scene.tissue.oscillator.stiffness *= 1.01;
                       }};
  check_fails(fault, {"stability/blow-up/euler-cromer", "stability/blow-up/leapfrog",
                      "stability/blow-up/rk4", "stability/map/euler-cromer", "stability/map/rk4",
                      "stability/drift/oscillator", "stability/zero-length"});
}

TEST("one per cent of mass is seen") {
  const Mutation mass{.name = "nodes 1 % lighter",
                      .model = [](Scene& scene, SpringNetwork& network) {
                        network.mass *= 0.99;
                        scene.tissue.oscillator.mass *= 0.99;
                      }};
  check_fails(mass, {"stability/blow-up/velocity-verlet", "stability/map/feynman-newton"});
}

TEST("a NaN at one node is never a pass") {
  const Mutation fault{.name = "NaN at one node", .trace = [](Trace& motion) {
                         motion.position(motion.position.rows() / 2, motion.position.cols() / 2) =
                             nan;
                       }};
  check_fails(fault, {"stability/blow-up/leapfrog", "stability/zero-length", "stability/huge-force",
                      "stability/denormals"});
}

TEST("a NaN in the energy is never a pass") {
  const Mutation fault{.name = "NaN in the energy", .trace = [](Trace& motion) {
                         if (motion.find("energy_j") == nullptr) { return; }
                         for (double& e : motion.values("energy_j")) { e = nan; }
                       }};
  check_fails(fault, {"stability/stiffness-contrast", "stability/mass-ratio", "stability/inverted",
                      "stability/drift/oscillator", "stability/drift/network"});
}

TEST("divergence that is not reported, or too late, is seen") {
  const Mutation silent{.name = "divergence kept silent",
                        .trace = [](Trace& motion) { motion.diverged = false; }};
  const Mutation late{.name = "divergence a tick late",
                      .trace = [](Trace& motion) { motion.diverged_at *= 2.0; }};
  check_fails(silent, {"stability/nan-injection"});
  check_fails(late, {"stability/nan-injection"});
}

TEST("energy that creeps up by a part in ten million a run is seen") {
  const Mutation fault{.name = "creeping energy", .trace = [](Trace& motion) {
                         const auto last = static_cast<double>(motion.position.cols() - 1);
                         for (Eigen::Index n = 0; n < motion.position.cols(); ++n) {
                           const double gain = 1.0 + 1e-7 * static_cast<double>(n) / last;
                           motion.position.col(n) *= gain;
                           if (motion.velocity.cols() > n) { motion.velocity.col(n) *= gain; }
                         }
                       }};
  check_fails(fault, {"stability/drift/oscillator"});
}

}  // namespace
