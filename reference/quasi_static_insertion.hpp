// SPDX-License-Identifier: MIT
#pragma once
/// Insertion so slow that nothing accelerates, without friction and with the stiffness at rest
/// (model/EQUATIONS.md, "Needle tip"): a chain of straight lines in (s, F).

#include <vector>

#include "model/problem/scene.hpp"

namespace palpate::reference {

/// c = w.K^-1 w [m/N], w the knot weights at a depth xi [m] of the tool's line times n: how far the
/// tip sinks in for each newton. 0 where only fixed nodes bear it. SolverError where the tissue can
/// move freely, or the scene has no tool.
double static_compliance(const Scene& scene, const SpringNetwork& network, double depth);

struct ForceDepthVertex {
  double place = 0.0;  ///< s [m]
  double force = 0.0;  ///< F [N]
};

/// From the skin to the place `end` [m]: the tip sticks at slope 1 / c(d), cuts at F_c, sticks at a
/// layer that resists more, and drops to F_c at once (a vertical line) at one that resists less.
/// Throws as above.
std::vector<ForceDepthVertex> force_depth_curve(const Scene& scene, const SpringNetwork& network,
                                                double end);

/// F at a place on the curve [N], the last of a vertical line; the end values beyond its ends.
double force_at(const std::vector<ForceDepthVertex>& curve, double place);

}  // namespace palpate::reference
