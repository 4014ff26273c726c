// SPDX-License-Identifier: MIT

#include "model/tissue/network_builder.hpp"
#include "tests/validation/planted_faults.hpp"
#include "validation/roll_out.hpp"

namespace PALPATE_FILE {

using namespace palpate;

Mutation in_materials(std::string name, double Material::*value, double factor) {
  return {.name = std::move(name), .model = [value, factor](Scene& scene, SpringNetwork&) {
            for (Material& material : scene.materials) { material.*value *= factor; }
          }};
}

TEST("every fault planted in an insertion fails the cases of needle and probe that measure it") {
  const Mutation thick{
      .name = "first layer 0.5 mm too thick",
      .model = [](Scene& scene, SpringNetwork&) { scene.tissue.layers.front().thickness += 5e-4; }};
  const Mutation slow{.name = "compliance of the syringe +1 %",
                      .model = [](Scene& scene, SpringNetwork&) {
                        if (scene.syringe) { scene.syringe->compliance *= 1.01; }
                      }};
  const Mutation nan_force{.name = "NaN in the force", .trace = [](Trace& run) {
                             std::vector<double>& force = run.values("tool.force_n");
                             force[force.size() / 2] = force.back() = quiet_nan;
                           }};
  const Mutation late{.name = "tool samples shifted by one", .trace = [](Trace& run) {
                        for (Column& column : run.columns) {
                          if (!column.name.starts_with("tool.")) { continue; }
                          std::shift_right(column.values.begin(), column.values.end(), 1);
                        }
                      }};
  const Mutation no_event{
      .name = "no loss of resistance", .trace = [](Trace& run) {
        std::erase_if(run.events, [](const Event& e) { return e.kind == "loss-of-resistance"; });
      }};
  const Mutation late_events{.name = "events two ticks late", .trace = [](Trace& run) {
                               for (Event& event : run.events) { event.time += 2e-3; }
                             }};
  const Mutation wide{.name = "needle 10 % too wide", .model = [](Scene& scene, SpringNetwork&) {
                        if (scene.needle) { scene.needle->diameter *= 1.1; }
                      }};
  const Mutation wide_disc{.name = "disc 10 % too wide", .model = [](Scene& scene, SpringNetwork&) {
                             if (scene.probe) { scene.probe->size *= 1.1; }
                           }};
  const Mutation blunt{.name = "tip radius +10 %", .model = [](Scene& scene, SpringNetwork&) {
                         if (scene.probe && scene.probe->tip_radius) {
                           *scene.probe->tip_radius *= 1.1;
                         }
                       }};
  const Mutation stiff_face{.name = "a rigid face instead of a uniform pressure",
                            .model = [](Scene& scene, SpringNetwork&) {
                              if (scene.probe) { scene.probe->face = Probe::FaceKind::rigid; }
                            }};
  const Mutation uneven{.name = "tissue 20 % stiffer for x > 0",
                        .model = [](Scene&, SpringNetwork& network) {
                          network.springs.change_each([&](Spring& s) {
                            const bool right = network.rest_position(0, s.a) > 0.0;
                            s.stiffness *= right ? 1.2 : 1.0;
                          });
                        }};
  const Mutation late_probe{.name = "place of the probe 100 ms late", .trace = [](Trace& run) {
                              for (Column& column : run.columns) {
                                if (column.name != "probe.x_m") { continue; }
                                std::shift_right(column.values.begin(), column.values.end(), 20);
                              }
                            }};
  const Mutation grid_bound{.name = "needle that widens with the spacing",
                            .model = [](Scene& scene, SpringNetwork&) {
                              if (!scene.needle) { return; }
                              scene.needle->diameter *= scene.tissue.block.spacing / 0.005;
                            }};
  const Mutation hollow{.name = "no volume terms",
                        .model = [](Scene&, SpringNetwork& network) { network.cells.clear(); }};
  const Mutation soft_skin{.name = "skin 20 % too soft",
                           .model = [](Scene& scene, SpringNetwork& network) {
                             for (Material& material : scene.materials) {
                               if (material.name != "skin") { continue; }
                               material.youngs_modulus *= 0.8;
                               network = build_network(scene);
                             }
                           }};
  const Mutation soft_dura{.name = "dura of half the modulus",
                           .model = [](Scene& scene, SpringNetwork& network) {
                             for (Material& material : scene.materials) {
                               if (material.name != "dura") { continue; }
                               material.youngs_modulus *= 0.5;
                               network = build_network(scene);
                             }
                           }};
  const Mutation relaxed{.name = "time constants of relaxation +1 %",
                         .model = [](Scene& scene, SpringNetwork&) {
                           for (Material& material : scene.materials) {
                             for (RelaxationBranch& branch : material.relaxation) {
                               branch.time *= 1.01;
                             }
                           }
                         }};
  check_red(
      "",
      {{wide, {"needle/continuum-stiffness"}},
       {soft_skin, {"needle/skin-dent", "probe/layer"}},
       {soft_dura, {"needle/dura"}},
       {grid_bound, {"needle/shipped-scenes"}},
       {blunt, {"probe/layer", "probe/half-space"}},
       {stiff_face, {"probe/half-space"}},
       {wide_disc, {"probe/layer", "probe/half-space"}},
       {uneven, {"probe/slide"}},
       {late_probe, {"probe/slide"}},
       {hollow, {"probe/over-bone", "probe/layer"}},
       {stiffer(),
        {"needle/chain", "needle/order", "needle/rest", "needle/momentum", "probe/palpation-map",
         "tissue/cube", "tissue/image"}},
       {reversed_damping(), {"needle/order", "needle/momentum", "needle/energy"}},
       {missing_spring(), {"needle/chain"}},
       {harder_to_cut(),
        {"needle/chain", "needle/layers", "needle/loss-of-resistance", "needle/parts"}},
       {in_materials("travel of friction +1 %", &Material::friction_travel, 1.01),
        {"needle/reference/material"}},
       {in_materials("toe +1 %", &Material::indentation_toe, 1.01), {"needle/reference/material"}},
       {relaxed, {"needle/reference/material"}},
       {in_materials("friction +5 %", &Material::friction, 1.05),
        {"needle/friction/loop", "needle/reference/continuous-20-mm-s"}},
       {thick, {"needle/chain", "needle/reference/continuous-20-mm-s", "needle/angles"}},
       {double_steps(), {"needle/order", "needle/momentum", "needle/reference/continuous-20-mm-s"}},
       {slow, {"needle/loss-of-resistance"}},
       {nan_force,
        {"needle/chain", "needle/momentum", "needle/parts", "needle/rest",
         "needle/reference/continuous-20-mm-s", "needle/stress", "needle/bone"}},
       {late, {"needle/momentum", "needle/order"}},
       {no_event, {"needle/layers", "needle/loss-of-resistance"}},
       {late_events, {"needle/reference/continuous-20-mm-s"}}});
}

TEST("every fault planted in a haptic loop fails the cases of haptics that measure it") {
  check_red("haptics/", {{delayed_loop(),
                          {"wall/boundary", "wall/z-width", "wall/passivity", "falcon/reference"}},
                         {stiffer(), {"falcon/reference"}}});
}

}  // namespace PALPATE_FILE
