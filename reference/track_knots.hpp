// SPDX-License-Identifier: MIT
#pragma once
/// How a tool's line is tied to the nodes of a network (model/EQUATIONS.md, "Needle line").

#include <vector>

#include "reference/needle_track.hpp"

namespace palpate::reference {

/// On a lattice one knot where the line meets each plane of nodes across z (none where it is beside
/// the plane), with bilinear weights; in any other network one for each slab of R/2, from the first
/// node on, that holds nodes nearer than R to the line, R the median spring length, weighted by
/// 1 - r/R. SolverError for a network without springs.
std::vector<TrackKnot> needle_knots(const Scene& scene, const SpringNetwork& network);

/// The skin beneath a probe: each node of the first plane by the part of its a x a cell (cut off at
/// the edge of the body) that the footprint covers; in any other network the z-min nodes beneath
/// the footprint in equal parts. SolverError when there is none.
TrackKnot probe_knot(const Scene& scene, const SpringNetwork& network);

}  // namespace palpate::reference
