// SPDX-License-Identifier: MIT
#pragma once
/// Checks a Scene against all rules and reports every broken rule.

#include <string>
#include <vector>

#include "model/problem/rules.hpp"
#include "model/problem/scene.hpp"

namespace palpate {

/// Message about a material name that is not among `known`.
std::string unknown_material(const std::string& name, const std::vector<Material>& known);

/// All broken rules of a scene, empty when it can be simulated: ranges of single keys
/// (scene_keys.hpp) and relations between keys. Keys of `materials` are "material[0].density". The
/// name of the integrator is not checked.
std::vector<Violation> check_scene(const Scene& scene);

}  // namespace palpate
