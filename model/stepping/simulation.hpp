// SPDX-License-Identifier: MIT
#pragma once
/// Simulation of a scene, one tick at a time. Everything is allocated on construction: tick()
/// allocates nothing, locks nothing and does no input or output, in either precision.

#include <memory>
#include <span>

#include "model/problem/problem.hpp"
#include "model/problem/trace.hpp"
#include "model/stepping/step_plan.hpp"
#include "model/stepping/tool_report.hpp"

namespace palpate {

enum class StepStatus { ok, diverged };

class Simulation {
 public:
  /// The scene must have passed check_scene. Throws what plan_steps throws.
  explicit Simulation(const Scene& scene, bool skip = true);
  /// A network made in memory, with the settings, loads and records of the scene.
  Simulation(const Scene& scene, const SpringNetwork& network, bool skip = true);
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  /// Position s of the hand's end of the coupling along the tool's line [m] and its velocity [m/s]
  /// during the next ticks. Only a drive of kind falcon uses it.
  void move_handle(double place, double velocity) noexcept;
  /// Advances by one tick. After `diverged` the state is that in which divergence was detected.
  StepStatus tick() noexcept;

  [[nodiscard]] double time() const noexcept;      ///< [s]
  [[nodiscard]] long ticks() const noexcept;       ///< done so far
  [[nodiscard]] long tick_count() const noexcept;  ///< in the scene's duration
  [[nodiscard]] const StepPlan& plan() const noexcept;
  [[nodiscard]] const Problem& problem() const noexcept;

  /// Name and unit of what sample() writes, in order.
  [[nodiscard]] const std::vector<Column>& columns() const noexcept;
  /// Writes the present values of the columns; `row` has one element for each.
  void sample(std::span<double> row) noexcept;
  /// Names of the columns of text; empty without a tool.
  [[nodiscard]] const std::vector<TextColumn>& text_columns() const noexcept;
  /// Writes their present values, appends the events since the last call and clears them.
  void sample_text(std::span<std::string> row, std::vector<Event>& events);
  /// Position of the coordinates of problem() [m].
  void coordinates(Eigen::Ref<Eigen::VectorXd> q) const noexcept;
  void velocities(Eigen::Ref<Eigen::VectorXd> v) noexcept;  ///< at the tick [m/s]
  /// All nodes [m], 3 x nodes; the oscillator has none.
  [[nodiscard]] NodeVectors node_positions() const;
  /// The same without allocating; `all` is 3 x nodes.
  void node_positions(Eigen::Ref<NodeVectors> all) noexcept;
  /// Kinetic plus elastic energy and the potential of gravity [J].
  [[nodiscard]] double energy() noexcept;
  /// Position s [m] and velocity s' [m/s] of the tool, without evaluating forces; zero without one.
  [[nodiscard]] ToolMotion tool_motion() const noexcept;
  /// Events of the tool since the last sample_text() or forget_tool_happenings().
  [[nodiscard]] std::span<const ToolHappening> tool_happenings() const noexcept;
  /// Clears the events without allocating.
  void forget_tool_happenings() noexcept;
  /// Present state of the tool; zero without one.
  [[nodiscard]] ToolReport tool() noexcept;
  [[nodiscard]] int zero_length_springs() const noexcept;
  [[nodiscard]] std::size_t spring_count() const noexcept;  ///< that are computed
  /// Share of the movable rows that is stepped now; 1 where nothing may sleep.
  [[nodiscard]] double awake_share() const noexcept;
  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  class Core;
  template <class Real> class CoreOf;
  void build(const Scene& scene, std::unique_ptr<Problem> problem, bool skip);
  std::unique_ptr<Core> core_;
};

}  // namespace palpate
