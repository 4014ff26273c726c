// SPDX-License-Identifier: MIT
#pragma once
/// What a needle cuts along its line (model/EQUATIONS.md, "Needle line").

#include <vector>

#include "reference/needle_track.hpp"

namespace palpate::reference {

/// Layers by thickness / n_z (the last goes on for ever), else the lattice's material, else nothing
/// to cut; then inclusions, the last that holds a point winning. Begins at `entry` = xi_0 [m].
/// SolverError for an unknown material.
std::vector<TrackInterval> track_intervals(const Scene& scene, double entry);

}  // namespace palpate::reference
