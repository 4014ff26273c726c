// SPDX-License-Identifier: MIT
#pragma once
/// Time loop that runs a subject through a scene and returns a Trace.

#include <Eigen/Core>
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "model/problem/scene.hpp"
#include "model/problem/spring_network.hpp"
#include "model/problem/trace.hpp"
#include "validation/certificate/paced_loop.hpp"
#include "validation/subject/falcon_loop.hpp"
#include "validation/subject/subject.hpp"

namespace palpate {

/// Permutes nodes, shuffles springs and swaps their ends at random; loads of the scene follow their
/// nodes. Returns the new index of every node.
std::vector<int> renumber(SpringNetwork& network, Scene& scene, std::uint64_t seed);

/// Permutes a network on construction and converts results back to the original order.
class OtherOrder {
 public:
  /// Does nothing if the seed is 0 or the network has no nodes.
  OtherOrder(std::uint64_t seed, SpringNetwork& network, Scene& scene);
  /// Converts coordinates of the free nodes (dof x times) of `network` to the original order. Empty
  /// matrices stay empty.
  void undo(const SpringNetwork& network, Eigen::MatrixXd& coordinates) const;

 private:
  SpringNetwork first_{};
  std::vector<int> node_of_{};  ///< new index of each node; empty: original order
};

struct CaseContext;

/// Fault planted in the candidate, used to check that a faulty candidate fails.
struct Mutation {
  std::string name{};
  std::function<void(Scene&, SpringNetwork&)>
      model{};                          ///< applied before the run; the network may be empty
  std::function<void(Trace&)> trace{};  ///< applied after the run
  int loop_delay = 0;                   ///< additional delay of every haptic loop [ticks]
  bool step_twice = false;              ///< every step advances by twice its length
};

/// Selection of the data that a trace contains besides the columns of the subject.
struct SampleOptions {
  long every = 1;             ///< ticks between rows; the first and the last tick always have one
  bool extremes = false;      ///< also rows at events and at the largest force, pressure and depth
  bool position = false;      ///< Trace::position
  bool velocity = false;      ///< Trace::velocity
  bool energy = false;        ///< column "energy_j"
  bool energy_range = false;  ///< write Trace::energy only
  bool tool = false;  ///< columns of ToolReport that trace.csv lacks, see tool_audit_columns()
  int frames = 0;     ///< number of frames, evenly spaced over the ticks
  int keyframes = 0;  ///< number of keyframes at the first ticks with events; one more at the
                      ///< largest tool force
  /// Network whose cells are checked at the frames, at events, and 200 times in between; adds the
  /// column "tissue.smallest_jacobian", which keeps its value between checks.
  const SpringNetwork* cells = nullptr;
};

/// Returns the audit columns "tool.velocity_m_per_s", "tool.tip_depth_m" (in the undeformed
/// tissue), "tool.deepest_cut_m", "tool.slip_m_per_s" (shaft relative to the tissue),
/// "tool.mass_kg", the force of the tissue on the tool "tool.on_x_n", "tool.on_y_n", "tool.on_z_n"
/// (tissue frame), and the energy losses "loss.cutting_j", "loss.friction_j", "loss.damping_j",
/// "loss.impact_j", "loss.impact_hand_j", "loss.impulse_ns", "loss.hand_j".
std::vector<Column> tool_audit_columns();

/// Decision of a hook at the border before a tick.
struct TickOrder {
  /// step: the next tick. hold: no tick in this period, the time of the scene stands still. end:
  /// the run ends here.
  enum class What { step, hold, end } what = What::step;
  std::optional<ToolInput> input{};  ///< replaces the recorded or resting grip of a coupled tool
};

/// Viewer and operator of a run: decides what happens at every border between two ticks, and sees
/// every tick. Its functions are called on the thread of the loop; they must not allocate, lock or
/// do I/O.
class TickHook {
 public:
  virtual ~TickHook() = default;
  virtual TickOrder before_tick(Subject& subject) noexcept = 0;
  /// `stepped` is false after a period without a tick. Without a clock, all times are 0.
  virtual void after_tick(Subject& subject, const certificate::TickTimes& times,
                          bool stepped) noexcept = 0;
};

struct RunControl {
  const std::atomic<bool>* stop = nullptr;       ///< read between ticks
  std::function<void(double share)> progress{};  ///< 0 to 1, at most a few times a second
  std::function<bool(const Trace&)> enough{};    ///< checked after each tick; true ends the run
  device::DeadlineClock* clock = nullptr;  ///< clock that paces the ticks; nullptr: no waiting
  FalconLoopOptions device{};     ///< options of the Falcon loop, for scenes driven by a Falcon
  FalconFacts* falcon = nullptr;  ///< output: facts of the Falcon loop
  /// Not for scenes driven by an emulated Falcon, whose loop decides its input.
  TickHook* hook = nullptr;
};

/// Runs a loaded subject until the scene ends, the state diverges or a stop is requested. The trace
/// contains the rows before the first state that is not finite or out of bounds. Throws
/// SubjectFailure if the subject crashes or does not answer.
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

/// Returns a scene for a network that is created in memory; step and duration in s.
Scene scene_of(const std::string& integrator, double step, double duration, int substeps = 1);

/// Returns the agreed problem of mass-spring programs: n x n x n nodes of 1 g, 10 mm apart, 26
/// neighbours with 50 N/m and 0.05 N s/m, one face fixed, 0.1 N on the middle node "tip" of the
/// opposite face; semi-implicit Euler with 1 ms.
Scene s26_scene(int nodes);

}  // namespace palpate
