// SPDX-License-Identifier: MIT
#pragma once
/// Test fixture of the cases of tools: scenes and helpers.

#include <string>
#include <vector>

#include "validation/case.hpp"
#include "validation/roll_out.hpp"

namespace palpate::tools {

/// Returns layers and materials from skin to dura, 24 mm deep. Moduli and forces of ligament are a
/// hundredth of their own, so explicit schemes are stable at the same strains.
Scene seven_soft_layers(double spacing = 0.004, int across = 4);

/// Returns the recipe of BMI 22 with full moduli of ligament; 46 mm deep, nodes 5 mm apart.
Scene seven_published_layers(int across);

/// Ten equal springs along z with the layers of the scene; the last node is fixed.
struct Chain {
  int springs = 10;
  double spacing = 0.002;    ///< [m]
  double stiffness = 500.0;  ///< k of each spring [N/m]
  double node_mass = 2e-4;   ///< [kg]
};
Scene chain_scene(const Chain& chain);

Material tissue_of(const std::string& name, double youngs_modulus, double cutting_force,
                   double friction, TissueRole role = TissueRole::tissue);

/// A run with one tool report per row.
struct Insertion {
  Trace trace{};
  std::vector<ToolReport> tool{};
};
Insertion insert(const CaseContext& context, const Scene& scene, SampleOptions options = {});

}  // namespace palpate::tools
