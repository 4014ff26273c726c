// SPDX-License-Identifier: MIT
#pragma once
/// The one loop that moves a subject: a scene in, a Trace out.

#include <atomic>
#include <functional>
#include <string>

#include "model/problem/scene.hpp"
#include "model/problem/trace.hpp"
#include "validation/subject/falcon_loop.hpp"
#include "validation/subject/subject.hpp"

namespace palpate {

struct CaseContext;

/// A fault planted in the candidate, to see that a verdict turns red.
struct Mutation {
  std::string name{};
  std::function<void(Scene&, SpringNetwork&)> model{};  ///< before the run; network may be empty
  std::function<void(Trace&)> trace{};                  ///< after the run
  int loop_delay = 0;                                   ///< further ticks in every haptic loop
  bool step_twice = false;                              ///< every step takes twice its length
};

/// Contents of a trace beside the columns of the subject.
struct SampleOptions {
  long every = 1;             ///< ticks between rows; the first and the last tick always have one
  bool position = false;      ///< Trace::position
  bool velocity = false;      ///< Trace::velocity
  bool energy = false;        ///< column "energy_j"
  bool energy_range = false;  ///< Trace::energy alone
  bool tool = false;  ///< columns of ToolReport that trace.csv lacks, see tool_audit_columns()
  int frames = 0;     ///< evenly over the ticks
  int keyframes = 0;  ///< at the first so many ticks with events, and at the largest tool force
};

/// "tool.velocity_m_per_s", "tool.tip_depth_m" (in the undeformed tissue), "tool.deepest_cut_m",
/// "tool.slip_m_per_s" (of the shaft against the tissue), "tool.mass_kg", and losses of energy:
/// "loss.cutting_j", "loss.friction_j", "loss.damping_j", "loss.impact_j", "loss.impact_hand_j",
/// "loss.impulse_ns", "loss.hand_j".
std::vector<Column> tool_audit_columns();

struct RunControl {
  const std::atomic<bool>* stop = nullptr;       ///< read between ticks
  std::function<void(double share)> progress{};  ///< 0 to 1, at most a few times a second
  std::function<bool(const Trace&)> enough{};    ///< true after a tick ends the run there
  device::DeadlineClock* clock = nullptr;        ///< each tick waits for it; nullptr: no waiting
  FalconLoopOptions device{};                    ///< of scenes whose drive is a Falcon
  FalconFacts* falcon = nullptr;                 ///< receives the facts of that device
};

/// Runs a loaded subject to the end of the scene, to divergence, or to a stop. The trace has every
/// row before the first state that is not finite or out of bounds.
Trace roll_out(Subject& subject, const Scene& scene, const SampleOptions& options = {},
               const RunControl& control = {});

/// Loads the candidate of a case with the mutation of the context, runs it, and applies the
/// mutation to the trace. `network` replaces the tissue of the scene unless it is nullptr.
Trace roll_out(const CaseContext& context, Scene scene, const SpringNetwork* network,
               const SampleOptions& options, RunControl control = {});
inline Trace roll_out(const CaseContext& context, Scene scene, const SampleOptions& options,
                      RunControl control = {}) {
  return roll_out(context, std::move(scene), nullptr, options, std::move(control));
}

/// Scene around a network that is made in memory.
Scene scene_of(const std::string& integrator, double step, double duration, int substeps = 1);

}  // namespace palpate
