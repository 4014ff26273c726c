// SPDX-License-Identifier: MIT
#pragma once
/// Stiffness of the tissue under the footprint of a probe, on a grid of positions.

#include <atomic>

#include "model/problem/scene.hpp"
#include "reference/static_equilibrium.hpp"
#include "validation/outcome.hpp"

namespace palpate {

/// Returns the stiffness map of a scene with a probe: x and y in mm, z in N/mm. Throws SolverError
/// if the tissue can move freely. Returns at once when `stop` becomes true, then with fewer values.
HeatMap palpation_map(const Scene& scene, const NetworkProblem& problem, const PalpationGrid& grid,
                      const std::atomic<bool>* stop = nullptr);

}  // namespace palpate
