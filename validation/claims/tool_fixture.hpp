// SPDX-License-Identifier: MIT
#pragma once
/// Scenes and helpers that the cases of tools share.

#include <string>
#include <vector>

#include "validation/case.hpp"
#include "validation/roll_out.hpp"

namespace palpate::tools {

/// Layers and materials between skin and dura with moduli that explicit schemes can follow: a
/// hundredth of those of ligament, forces likewise, so that strains stay as they are. 24 mm deep.
Scene seven_soft_layers(double spacing = 0.004, int across = 4);

/// The recipe of body-mass index 22, moduli of ligament in full (finite-element ligament tables);
/// 46 mm deep, nodes 5 mm apart.
Scene seven_published_layers(int across);

/// Ten equal springs along z whose layers are those of `Scene::tissue.layers`; the last node fixed.
struct Chain {
  int springs = 10;
  double spacing = 0.002;    ///< [m]
  double stiffness = 500.0;  ///< k of each spring [N/m]
  double node_mass = 2e-4;   ///< [kg]
};
Scene chain_scene(const Chain& chain);

Material tissue_of(const std::string& name, double youngs_modulus, double cutting_force,
                   double friction, TissueRole role = TissueRole::tissue);

/// Columns of the tool as one report for each row. The trace was sampled with SampleOptions::tool.
std::vector<ToolReport> tool_rows(const Trace& trace);

Series curve(const std::string& label, std::vector<double> x, std::vector<double> y,
             Series::Style style = Series::Style::line);

std::vector<Case> chain_cases();     ///< a chain under the needle against its exact curve
std::vector<Case> static_cases();    ///< a block against its static curve
std::vector<Case> balance_cases();   ///< parts, momentum, energy
std::vector<Case> friction_cases();  ///< hysteresis, rest
std::vector<Case> passage_cases();   ///< layers in order, loss of resistance, bone, angles, spacing
std::vector<Case> reference_cases();  ///< against the reference that finds events as roots
std::vector<Case> stress_cases();     ///< extremes of speed, force, step
std::vector<Case> probe_cases();      ///< spread, palpation over bone
std::vector<Case> moduli_cases();     ///< published moduli at 1 kHz

}  // namespace palpate::tools
