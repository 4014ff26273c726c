// SPDX-License-Identifier: MIT
#pragma once
/// Quasi-static insertion without friction and with the stiffness at rest
/// (model/EQUATIONS.md, "Needle tip"): a piecewise linear curve in (s, F).

#include <vector>

#include "model/problem/scene.hpp"

namespace palpate::reference {

/// Returns the indentation of the tip per force, c = w.K^-1 w [m/N], with w the contact point
/// weights at a depth xi [m] times n, without that of the contact. The value is 0 if only fixed
/// nodes support the tip. Throws SolverError if the tissue can move freely, if the scene has no
/// tool, or if tissue or contact are not linear and elastic.
double static_compliance(const Scene& scene, const SpringNetwork& network, double depth);

struct ForceDepthVertex {
  double place = 0.0;  ///< s [m]
  double force = 0.0;  ///< F [N]
};

/// Returns the force-depth curve from the skin to the position `end` [m]. The tip sticks with slope
/// 1 / (c(d) + c_s(d)), cuts at F_c, sticks at a layer of higher resistance, and drops to F_c at
/// once (a vertical line) at one of lower resistance. Throws as static_compliance() does.
std::vector<ForceDepthVertex> force_depth_curve(const Scene& scene, const SpringNetwork& network,
                                                double end);

/// Returns F at a position on the curve [N]: the last value of a vertical line, and the end values
/// outside the curve.
double force_at(const std::vector<ForceDepthVertex>& curve, double place);

}  // namespace palpate::reference
