// SPDX-License-Identifier: MIT
#pragma once
/// Every physical rule on a Scene, checked at once.

#include <string>
#include <vector>

#include "model/problem/rules.hpp"
#include "model/problem/scene.hpp"

namespace palpate {

/// What to say of a material that is not among `known`.
std::string unknown_material(const std::string& name, const std::vector<Material>& known);

/// All broken rules of a scene; empty when it can be simulated.
std::vector<Violation> check_scene(const Scene& scene);

// The rules on needle, probe, drive and syringe: part of check_scene.

void check_tool(const Scene& scene, Rules& rules);

/// Whether the scene's needle meets a tissue that says nothing of cutting and friction, so that
/// [[layer]] tables must.
bool needs_layers_for_needle(const Scene& scene);

}  // namespace palpate
