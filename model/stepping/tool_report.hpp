// SPDX-License-Identifier: MIT
#pragma once
/// Modes, forces, energy losses and events of a tool.

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <string_view>
#include <vector>

#include "model/problem/scene.hpp"
#include "model/problem/trace.hpp"

namespace palpate {

/// Returns the columns of the tool of a scene in a trace.
std::vector<Column> tool_columns(const Scene& scene);
/// Returns the text columns "tool.layer" and "tool.event".
inline std::vector<TextColumn> tool_text_columns() {
  return {{"tool.layer", {}}, {"tool.event", {}}};
}

enum class TipMode { outside, stuck, cutting, in_track };
enum class ShaftMode { stick, forward, backward };  ///< forward: the needle slides into the tissue

/// Forces on the tool along its direction [N]; resisting forces are positive.
struct ToolForces {
  double cutting = 0.0;
  double friction = 0.0;
  double stiffness = 0.0;
  double total = 0.0;                      ///< sum of the above
  double applied = 0.0;                    ///< by the hand
  double lateral = 0.0;                    ///< magnitude of the lateral tissue force
  Eigen::Vector3d on_tool{0.0, 0.0, 0.0};  ///< force of the tissue on the tool, tissue frame
};

/// Returns the magnitude of the part of a force across a direction of length 1; 0 if it is no more
/// than the rounding of the force.
inline double lateral_force(const Eigen::Vector3d& force, const Eigen::Vector3d& direction) {
  const double across = (force - force.dot(direction) * direction).norm();
  return across > 8.0 * std::numeric_limits<double>::epsilon() * force.norm() ? across : 0.0;
}

enum class ToolEvent { contact, puncture, loss_of_resistance, bone, dural_puncture, withdrawn };

struct ToolHappening {
  double time = 0.0;  ///< end of the step in which it was detected [s]
  ToolEvent event = ToolEvent::contact;
  std::size_t interval = 0;  ///< interval of the path
};

/// Energy dissipated or supplied since the start [J].
struct ToolLosses {
  double cutting = 0.0;
  double friction = 0.0;
  double damping = 0.0;  ///< of the tissue; computed only if the scene requests an audit
  double impact = 0.0;   ///< plastic impacts at contact onset and at jumps of the drive
  double jerk = 0.0;     ///< work of the hand in these impacts
  double impulse = 0.0;  ///< momentum along the tool that impacts transferred to the tissue [N s]
  double hand = 0.0;     ///< other work of the hand, by the trapezoidal rule over each step
};

/// Returns the name used in traces, e.g. "loss-of-resistance".
std::string_view name_of(ToolEvent event);

struct ToolMotion {
  double place = 0.0;     ///< s [m]
  double velocity = 0.0;  ///< s' [m/s]
};

/// State of a tool for audits of momentum and energy.
struct ToolReport {
  double place = 0.0;     ///< s [m]
  double velocity = 0.0;  ///< s' [m/s]
  double depth = 0.0;     ///< of the tip, in undeformed tissue [m]
  double cut = 0.0;       ///< largest cut depth so far [m]
  double slip = 0.0;      ///< sliding velocity of the shaft relative to the tissue [m/s]
  double mass = 0.0;      ///< [kg]; zero under a prescribed trajectory
  bool touching = false;  ///< the tip is on the tissue or in it
  ToolForces forces{};
  ToolLosses losses{};
};

}  // namespace palpate
