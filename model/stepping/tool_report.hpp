// SPDX-License-Identifier: MIT
#pragma once
/// What a tool reports: its modes, forces, losses and what happened to it.

#include <cstddef>
#include <string_view>

namespace palpate {

enum class TipMode { outside, stuck, cutting, in_track };
enum class ShaftMode { stick, forward, backward };  ///< forward: the needle slides into the tissue

/// Forces on the tool along its direction [N], resisting ones positive.
struct ToolForces {
  double cutting = 0.0;
  double friction = 0.0;
  double stiffness = 0.0;
  double total = 0.0;    ///< their sum
  double applied = 0.0;  ///< of the hand
  double lateral = 0.0;  ///< magnitude of what the tissue presses sideways
};

enum class ToolEvent { contact, puncture, loss_of_resistance, bone, dural_puncture, withdrawn };

struct ToolHappening {
  double time = 0.0;  ///< [s] end of the step in which it was seen
  ToolEvent event = ToolEvent::contact;
  std::size_t interval = 0;  ///< of the path
};

/// Energy that left the mechanics since the start, or came in [J].
struct ToolLosses {
  double cutting = 0.0;
  double friction = 0.0;
  double damping = 0.0;  ///< of the tissue; only where the scene asks for an audit
  double impact = 0.0;   ///< plastic impacts where contacts begin or the drive jumps
  double jerk = 0.0;     ///< work of the hand in such impacts
  double impulse = 0.0;  ///< momentum along the tool that impacts gave the tissue [N s]
  double hand = 0.0;     ///< its other work: trapezoids over each step, from its first and last
                         ///< evaluation, so for schemes that evaluate at both ends
};

/// As in traces: "contact", "puncture", "loss-of-resistance", "bone", "dural-puncture",
/// "withdrawn".
std::string_view name_of(ToolEvent event);

// A scene's tool at an instant.

struct ToolMotion {
  double place = 0.0;     ///< s [m]
  double velocity = 0.0;  ///< s' [m/s]
};

/// For audits of momentum and energy.
struct ToolReport {
  double place = 0.0;     ///< s [m]
  double velocity = 0.0;  ///< s' [m/s]
  double depth = 0.0;     ///< of the tip in undeformed tissue [m]
  double cut = 0.0;       ///< deepest cut [m]
  double slip = 0.0;      ///< of the shaft against the tissue [m/s]
  double mass = 0.0;      ///< [kg]; zero under a prescribed trajectory
  ToolForces forces{};
  ToolLosses losses{};
};

}  // namespace palpate
