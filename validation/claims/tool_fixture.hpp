// SPDX-License-Identifier: MIT
#pragma once
/// Test fixture of the cases of tools: scenes and helpers.

#include <cmath>
#include <string>
#include <vector>

#include "validation/case.hpp"
#include "validation/roll_out.hpp"

namespace palpate::tools {

inline Material tissue_of(const std::string& name, double youngs_modulus, double cutting_force,
                          double friction, TissueRole role = TissueRole::tissue) {
  return {.name = name,
          .youngs_modulus = youngs_modulus,
          .density = 1000.0,
          .damping_ratio = 0.5,
          .cutting_force = cutting_force,
          .friction = friction,
          .role = role};
}

/// Returns layers and materials from skin to dura, 24 mm deep. Moduli and forces of ligament are a
/// hundredth of their own, so explicit schemes are stable at the same strains.
inline Scene seven_soft_layers(double spacing = 0.004, int across = 4) {
  Scene scene;
  scene.tissue.source = Source::layers;
  scene.tissue.block = {.nodes = {across, across}, .spacing = spacing, .connectivity = 26};
  scene.tissue.fixed = {Face::z_max, Face::x_min, Face::x_max, Face::y_min, Face::y_max};
  scene.materials = {tissue_of("skin", 200e3, 0.5, 5.0),
                     tissue_of("fat", 40e3, 0.1, 2.0),
                     tissue_of("supraspinous", 300e3, 0.6, 20.0),
                     tissue_of("interspinous", 300e3, 0.8, 10.0),
                     tissue_of("flavum", 500e3, 1.2, 40.0),
                     tissue_of("epidural", 40e3, 0.0, 0.0, TissueRole::epidural_space),
                     tissue_of("dura", 400e3, 0.4, 0.0, TissueRole::dura)};
  scene.tissue.layers = {{"skin", "skin", 0.002},
                         {"fat", "fat", 0.0048},
                         {"supraspinous ligament", "supraspinous", 0.003},
                         {"interspinous ligament", "interspinous", 0.006},
                         {"ligamentum flavum", "flavum", 0.0034},
                         {"epidural space", "epidural", 0.004},
                         {"dura", "dura", 0.0008}};
  scene.needle = Needle{};
  scene.drive = Drive{.speed = 0.02};
  return scene;
}

/// Returns the recipe of BMI 22 with full moduli of ligament; 46 mm deep, nodes 5 mm apart.
inline Scene seven_published_layers(int across) {
  Scene scene = seven_soft_layers(0.005, across);
  scene.materials = {tissue_of("skin", 755e3, 3.68, 91.0),
                     tissue_of("fat", 9.1e3, 0.2, 20.0),
                     tissue_of("supraspinous", 8e6, 2.65, 320.0),
                     tissue_of("interspinous", 10e6, 4.56, 74.0),
                     tissue_of("flavum", 15e6, 7.40, 354.0),
                     tissue_of("epidural", 2.4e3, 0.0, 0.0, TissueRole::epidural_space),
                     tissue_of("dura", 12.2e6, 2.0, 0.0, TissueRole::dura)};
  scene.tissue.layers[3].thickness = 0.0261;
  scene.tissue.layers[5].thickness = 0.006;
  scene.tissue.layers[6].thickness = 0.0007;
  return scene;
}

/// Ten equal springs along z with the layers of the scene; the last node is fixed.
struct Chain {
  int springs = 10;
  double spacing = 0.002;    ///< [m]
  double stiffness = 500.0;  ///< k of each spring [N/m]
  double node_mass = 2e-4;   ///< [kg]
};
inline Scene chain_scene(const Chain& chain) {
  Scene scene;
  scene.tissue.source = Source::network;
  const int nodes = chain.springs + 1;
  SpringNetwork& network = scene.tissue.network;
  network.rest_position.setZero(3, nodes);
  network.mass.setConstant(nodes, chain.node_mass);
  network.fixed.assign(static_cast<std::size_t>(nodes), 0);
  network.fixed.back() = 1;
  const double viscosity = std::sqrt(2.0 * chain.stiffness * chain.node_mass);  // ratio 1
  for (int i = 0; i < nodes; ++i) {
    network.rest_position(2, i) = i * chain.spacing;
    if (i > 0) { network.springs.push_back({i - 1, i, chain.stiffness, viscosity, chain.spacing}); }
  }
  scene.needle = Needle{};
  scene.drive = Drive{.speed = 0.02};
  return scene;
}

inline std::vector<ToolReport> tool_rows(const Trace& trace) {
  std::vector<ToolReport> rows(trace.rows());
  const auto fill = [&](const char* name, double& (*member)(ToolReport&)) {
    const std::vector<double>& values = trace.values(name);
    for (std::size_t n = 0; n < rows.size(); ++n) { member(rows[n]) = values[n]; }
  };
  fill("tool.insertion_m", [](ToolReport& t) -> double& { return t.place; });
  fill("tool.velocity_m_per_s", [](ToolReport& t) -> double& { return t.velocity; });
  fill("tool.tip_depth_m", [](ToolReport& t) -> double& { return t.depth; });
  fill("tool.deepest_cut_m", [](ToolReport& t) -> double& { return t.cut; });
  fill("tool.slip_m_per_s", [](ToolReport& t) -> double& { return t.slip; });
  fill("tool.mass_kg", [](ToolReport& t) -> double& { return t.mass; });
  fill("tool.force_n", [](ToolReport& t) -> double& { return t.forces.total; });
  fill("tool.cutting_n", [](ToolReport& t) -> double& { return t.forces.cutting; });
  fill("tool.friction_n", [](ToolReport& t) -> double& { return t.forces.friction; });
  fill("tool.stiffness_n", [](ToolReport& t) -> double& { return t.forces.stiffness; });
  fill("tool.applied_n", [](ToolReport& t) -> double& { return t.forces.applied; });
  fill("tool.lateral_n", [](ToolReport& t) -> double& { return t.forces.lateral; });
  fill("tool.on_x_n", [](ToolReport& t) -> double& { return t.forces.on_tool.x(); });
  fill("tool.on_y_n", [](ToolReport& t) -> double& { return t.forces.on_tool.y(); });
  fill("tool.on_z_n", [](ToolReport& t) -> double& { return t.forces.on_tool.z(); });
  fill("loss.cutting_j", [](ToolReport& t) -> double& { return t.losses.cutting; });
  fill("loss.friction_j", [](ToolReport& t) -> double& { return t.losses.friction; });
  fill("loss.damping_j", [](ToolReport& t) -> double& { return t.losses.damping; });
  fill("loss.impact_j", [](ToolReport& t) -> double& { return t.losses.impact; });
  fill("loss.impact_hand_j", [](ToolReport& t) -> double& { return t.losses.jerk; });
  fill("loss.impulse_ns", [](ToolReport& t) -> double& { return t.losses.impulse; });
  fill("loss.hand_j", [](ToolReport& t) -> double& { return t.losses.hand; });
  return rows;
}

/// A run with one tool report per row.
struct Insertion {
  Trace trace{};
  std::vector<ToolReport> tool{};
};
inline Insertion insert(const CaseContext& context, const Scene& scene,
                        SampleOptions options = {}) {
  options.tool = true;
  Insertion insertion{.trace = roll_out(context, scene, options)};
  insertion.tool = tool_rows(insertion.trace);
  return insertion;
}

}  // namespace palpate::tools
