// SPDX-License-Identifier: MIT
#pragma once
/// What a probe feels over a grid of places: how stiff the tissue is under its footprint.

#include <Eigen/Core>

#include "model/problem/scene.hpp"
#include "reference/static_equilibrium.hpp"
#include "validation/outcome.hpp"

namespace palpate {

/// The stiffness 1 / (w.K^-1 w) [N/m] of a tissue at rest under the footprint w of the scene's
/// probe at a place of the skin [m]; infinite on bone alone. K is the caller's: one for all places.
double stiffness_felt(const Scene& scene, const NetworkProblem& problem,
                      const reference::StaticResponse& response, const Eigen::Vector2d& place);

/// Of a scene with a probe: the whole grid, x and y in mm, z in N/mm. SolverError where the tissue
/// can move freely.
HeatMap palpation_map(const Scene& scene, const NetworkProblem& problem, const PalpationGrid& grid);

}  // namespace palpate
