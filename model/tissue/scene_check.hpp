// SPDX-License-Identifier: MIT
#pragma once
/// Check of a Scene against all rules.

#include <string>
#include <vector>

#include "model/problem/rules.hpp"
#include "model/problem/scene.hpp"

namespace palpate {

/// Returns the message about a material name that is not in `known`.
std::string unknown_material(const std::string& name, const std::vector<Material>& known);

/// Returns all violations in a scene: ranges of single keys (scene_keys.hpp) and relations between
/// keys. The result is empty if the scene can be simulated. Keys of `materials` have the form
/// "material[0].density". The name of the integrator is not checked.
std::vector<Violation> check_scene(const Scene& scene);

}  // namespace palpate
