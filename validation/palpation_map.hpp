// SPDX-License-Identifier: MIT
#pragma once
/// Stiffness of the tissue under the footprint of a probe, on a grid of positions.

#include <Eigen/Core>

#include "model/problem/scene.hpp"
#include "reference/static_equilibrium.hpp"
#include "validation/outcome.hpp"

namespace palpate {

/// Returns the stiffness 1 / (w.K^-1 w) [N/m] of a tissue at rest under the footprint w of the
/// scene's probe at a skin position [m]; infinity on bone alone. `response` factorises K once for
/// all positions.
double stiffness_felt(const Scene& scene, const NetworkProblem& problem,
                      const reference::StaticResponse& response, const Eigen::Vector2d& place);

/// Returns the stiffness map of a scene with a probe: x and y in mm, z in N/mm. Throws SolverError
/// if the tissue can move freely.
HeatMap palpation_map(const Scene& scene, const NetworkProblem& problem, const PalpationGrid& grid);

}  // namespace palpate
