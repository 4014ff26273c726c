// SPDX-License-Identifier: MIT
#pragma once
/// Test fixture of the cases of tools: scenes and helpers.

#include <string>
#include <vector>

#include "validation/case.hpp"
#include "validation/roll_out.hpp"

namespace palpate::tools {

/// Returns layers and materials from skin to dura, 24 mm deep. Moduli are a hundredth of those of
/// ligament so that explicit schemes are stable; forces are scaled likewise, so strains are
/// unchanged.
Scene seven_soft_layers(double spacing = 0.004, int across = 4);

/// Returns the recipe of body-mass index 22 with full moduli of ligament (finite-element ligament
/// tables); 46 mm deep, nodes 5 mm apart.
Scene seven_published_layers(int across);

/// Chain of ten equal springs along z with the layers of `Scene::tissue.layers`; the last node is
/// fixed.
struct Chain {
  int springs = 10;
  double spacing = 0.002;    ///< [m]
  double stiffness = 500.0;  ///< k of each spring [N/m]
  double node_mass = 2e-4;   ///< [kg]
};
Scene chain_scene(const Chain& chain);

Material tissue_of(const std::string& name, double youngs_modulus, double cutting_force,
                   double friction, TissueRole role = TissueRole::tissue);

/// Returns one tool report per row from the columns of the tool. The trace must be sampled with
/// SampleOptions::tool.
std::vector<ToolReport> tool_rows(const Trace& trace);

Series curve(const std::string& label, std::vector<double> x, std::vector<double> y,
             Series::Style style = Series::Style::line);

std::vector<Case> chain_cases();     ///< a chain under the needle compared with its exact curve
std::vector<Case> static_cases();    ///< a block compared with its static curve
std::vector<Case> balance_cases();   ///< parts, momentum, energy
std::vector<Case> friction_cases();  ///< hysteresis, rest
std::vector<Case> passage_cases();   ///< layers in order, loss of resistance, bone, angles, spacing
std::vector<Case>
reference_cases();  ///< compared with a reference that locates events by root finding
std::vector<Case> stress_cases();  ///< extremes of speed, force, step
std::vector<Case> probe_cases();   ///< spread, palpation over bone
std::vector<Case> moduli_cases();  ///< published moduli at 1 kHz

}  // namespace palpate::tools
