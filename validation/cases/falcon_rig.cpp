// SPDX-License-Identifier: MIT
#include "validation/cases/falcon_rig.hpp"

#include "model/dynamics/network_builder.hpp"
#include "validation/cases/haptic_rig.hpp"
#include "validation/cases/tool_setting.hpp"

namespace palpate::haptics {

Held hold(const CaseContext& context, Scene scene) {
  SpringNetwork network = build_network(scene);
  if (context.mutation != nullptr && context.mutation->model) {
    context.mutation->model(scene, network);
  }
  Simulation simulation(scene, network, context.skip);
  FalconLoop loop(scene, simulation, {.extra_delay = extra_delay(context)});
  Held held;
  held.run = roll_out(simulation, {.falcon = &loop});
  held.facts = loop.facts();
  return held;
}

Scene chain_in_hand(bool quick, double stiffness) {
  Scene scene = tools::chain_scene({.stiffness = stiffness});
  scene.materials = {tools::tissue_of("tough", 1.0, 1000.0, 0.0)};
  scene.tissue.layers = {{"tough", "tough", 0.05}};
  scene.drive = Drive{.kind = Drive::Kind::falcon, .speed = 0.03, .depth = 0.003};
  scene.falcon = FalconDrive{.quantised = false, .friction = false};
  scene.simulation = {.duration = quick ? 0.3 : 1.0,
                      .step = 1e-3,
                      .substeps = 40,
                      .integrator = "velocity-verlet"};
  return scene;
}

}  // namespace palpate::haptics
