// SPDX-License-Identifier: MIT
#pragma once
/// The rules on needle, probe, drive and syringe: part of check_scene.

#include "model/dynamics/rules.hpp"
#include "model/dynamics/scene.hpp"

namespace palpate {

void check_tool(const Scene& scene, Rules& rules);

/// Whether the scene's needle meets a tissue that says nothing of cutting and friction, so that
/// [[layer]] tables must.
bool needs_layers_for_needle(const Scene& scene);

}  // namespace palpate
