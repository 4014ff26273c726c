// SPDX-License-Identifier: MIT

#include "tests/validation/planted_faults.hpp"

namespace PALPATE_FILE {

using namespace palpate;

/// Multiplies displacements by a factor, as a wrong unit or a stiffness counted twice does.
Mutation scaled(double factor) {
  return {.name = "displacements times " + std::to_string(factor),
          .trace = [factor](Trace& motion) {
            for (const char* name : {"tip.z_m", "end.z_m"}) {
              if (motion.find(name) == nullptr) { continue; }
              std::vector<double>& z = motion.values(name);
              const double start = z.front();
              for (double& one : z) { one = start + factor * (one - start); }
            }
          }};
}

Mutation odd_runs() {
  return {.name = "another last bit in every second run", .trace = [](Trace& motion) {
            static bool odd = false;
            odd = !odd;
            if (!odd || motion.find("tip.z_m") == nullptr) { return; }
            for (double& z : motion.values("tip.z_m")) { z *= 1.0 + 1e-15; }
          }};
}

Mutation drifting() {
  return {.name = "a velocity that grows", .trace = [](Trace& motion) {
            if (motion.velocity.size() > 0) { motion.velocity.rightCols(1).array() += 1e-3; }
            if (motion.position.size() > 0) { motion.position.rightCols(1).array() += 1e-3; }
            if (motion.find("energy_j") != nullptr) { motion.values("energy_j").back() *= 1.5; }
            if (motion.find("tip.z_m") != nullptr) { motion.values("tip.z_m").back() += 1e-3; }
          }};
}

Mutation weightless() {
  return {.name = "gravity ignored",
          .model = [](Scene& scene, SpringNetwork&) { scene.tissue.gravity.setZero(); }};
}

Mutation first_load_alone() {
  return {.name = "no load after the first", .model = [](Scene& scene, SpringNetwork&) {
            if (scene.loads.size() > 1) { scene.loads.resize(1); }
          }};
}

Mutation one_substep() {
  return {.name = "substeps ignored",
          .model = [](Scene& scene, SpringNetwork&) { scene.simulation.substeps = 1; }};
}

Mutation weaker_force() {
  return {.name = "four fifths of the force on the tool", .trace = [](Trace& motion) {
            if (motion.find("tool.force_n") == nullptr) { return; }
            for (double& force : motion.values("tool.force_n")) { force *= 0.8; }
          }};
}

/// The force of the tissue while the tool is drawn back.
Mutation rough_withdrawal() {
  return {.name = "a fifth more force on a tool that is drawn back", .trace = [](Trace& motion) {
            if (motion.find("tool.force_n") == nullptr) { return; }
            for (double& force : motion.values("tool.force_n")) {
              force *= force < 0.0 ? 1.2 : 1.0;
            }
          }};
}

Mutation silent(const char* column) {
  return {.name = std::string("no ") + column, .trace = [column](Trace& motion) {
            if (motion.find(column) == nullptr) { return; }
            std::ranges::fill(motion.values(column), 0.0);
          }};
}

TEST("every fault planted in a subject fails the cases that measure its effect") {
  static bool second = false;
  Mutation one_turned = drifting();
  one_turned.trace = [](Trace& motion) {
    second = !second;
    if (second && motion.position.size() > 0) { motion.position.rightCols(1).array() += 1e-3; }
  };
  check_red("subject/", {{scaled(1.2), {"s26", "static", "chain", "audit/drawn"}},
                         {stiffer(), {"static"}},
                         {scaled(0.0), {"audit/stiffness"}},
                         {late_frames(), {"first-step"}},
                         {drifting(), {"momentum", "energy", "rest", "patch"}},
                         {missing_spring(), {"patch"}},
                         {weightless(), {"audit/drawn"}},
                         {first_load_alone(), {"audit/drawn"}},
                         {one_turned, {"invariance"}},
                         {odd_runs(), {"audit/repeat"}},
                         {one_substep(), {"audit/substeps"}},
                         {rough_withdrawal(), {"needle"}},
                         {silent("tool.velocity_m_per_s"), {"moved"}},
                         {silent("tool.applied_n"), {"moved"}},
                         {weaker_force(), {"needle", "probe", "moved", "layered"}}});
}

}  // namespace PALPATE_FILE
