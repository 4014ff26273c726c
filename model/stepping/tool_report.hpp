// SPDX-License-Identifier: MIT
#pragma once
/// A scene's tool at an instant.

#include "model/stepping/tool_forces.hpp"

namespace palpate {

struct ToolMotion {
  double place = 0.0;     ///< s [m]
  double velocity = 0.0;  ///< s' [m/s]
};

/// For audits of momentum and energy.
struct ToolReport {
  double place = 0.0;       ///< s [m]
  double velocity = 0.0;    ///< s' [m/s]
  double depth = 0.0;       ///< of the tip in undeformed tissue [m]
  double cut = 0.0;         ///< deepest cut [m]
  double slip = 0.0;        ///< of the shaft against the tissue [m/s]
  double mass = 0.0;        ///< [kg]; zero under a prescribed trajectory
  ToolForces forces{};
  ToolLosses losses{};
};

}  // namespace palpate
