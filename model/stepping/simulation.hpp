// SPDX-License-Identifier: MIT
#pragma once
/// Simulation of a scene, one tick at a time. tick() does not allocate, lock, read or write files.

#include <memory>
#include <span>

#include "model/problem/problem.hpp"
#include "model/problem/trace.hpp"
#include "model/stepping/step_plan.hpp"
#include "model/stepping/tool_report.hpp"

namespace palpate {

enum class StepStatus { ok, diverged };

/// Returns the columns of the records of a scene with tissue.
std::vector<Column> record_columns(const Scene& scene);

class Simulation {
 public:
  /// The scene must have passed check_scene. Throws the exceptions of plan_steps.
  explicit Simulation(const Scene& scene, bool skip = true);
  /// Simulates the given network with the settings, loads and records of the scene.
  Simulation(const Scene& scene, const SpringNetwork& network, bool skip = true);
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  /// Sets the hand's end of the coupling for the next ticks: position s along the tool's line [m]
  /// and velocity [m/s]. Only a drive of kind falcon uses it.
  void move_handle(double place, double velocity) noexcept;
  /// Advances by one tick.
  StepStatus tick() noexcept;
  /// Prepares continue_from(). `from` is a simulation of the same scene with other materials, which
  /// may be ticking: only what a tick does not change is read. Allocates. Throws
  /// std::invalid_argument if its state does not fit this one.
  void prepare_to_continue(const Simulation& from);
  /// Takes time, positions, velocities, tool, events and internal variables of the simulation of
  /// prepare_to_continue(), between two ticks. Strains are kept; forces follow the new materials.
  /// Does not allocate.
  void continue_from(Simulation& from) noexcept;

  [[nodiscard]] double time() const noexcept;      ///< [s]
  [[nodiscard]] long ticks() const noexcept;       ///< completed
  [[nodiscard]] long tick_count() const noexcept;  ///< number of ticks in the scene's duration
  [[nodiscard]] const StepPlan& plan() const noexcept;
  [[nodiscard]] const Problem& problem() const noexcept;

  /// Names and units of the values that sample() writes, in the same order.
  [[nodiscard]] const std::vector<Column>& columns() const noexcept;
  /// Writes the current values of the columns; `row` has one element per column.
  void sample(std::span<double> row) noexcept;
  /// Names of the text columns; empty without a tool.
  [[nodiscard]] const std::vector<TextColumn>& text_columns() const noexcept;
  /// Writes the text values, appends the events since the last call to `events` and clears them.
  void sample_text(std::span<std::string> row, std::vector<Event>& events);
  /// Writes the position of the coordinates of problem() [m].
  void coordinates(Eigen::Ref<Eigen::VectorXd> q) const noexcept;
  void velocities(Eigen::Ref<Eigen::VectorXd> v) noexcept;  ///< at the tick [m/s]
  /// Positions of all nodes [m], 3 x nodes; empty for the oscillator.
  [[nodiscard]] NodeVectors node_positions() const;
  /// Writes the positions of all nodes [m] without allocating; `all` is 3 x nodes.
  void node_positions(Eigen::Ref<NodeVectors> all) const noexcept;
  /// Kinetic plus elastic energy and the potential of gravity [J].
  [[nodiscard]] double energy() noexcept;
  /// Position and velocity of the tool; zero without a tool.
  [[nodiscard]] ToolMotion tool_motion() const noexcept;
  /// Events of the tool since the last call of sample_text() or forget_tool_happenings().
  [[nodiscard]] std::span<const ToolHappening> tool_happenings() const noexcept;
  /// Clears the events without allocating.
  void forget_tool_happenings() noexcept;
  /// Current state of the tool; zero without a tool.
  [[nodiscard]] ToolReport tool() noexcept;
  [[nodiscard]] int zero_length_springs() const noexcept;
  /// Steps that `simulation.solver_corrections` ended.
  [[nodiscard]] LimitedSteps limited_steps() const noexcept;
  [[nodiscard]] std::size_t spring_count() const noexcept;  ///< number of springs that are computed
  /// Fraction of the movable rows that is currently integrated; 1 if no row may sleep.
  [[nodiscard]] double awake_share() const noexcept;
  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  class Core;
  template <class Real> class CoreOf;
  void build(const Scene& scene, std::unique_ptr<Problem> problem, bool skip);
  std::unique_ptr<Core> core_;
};

}  // namespace palpate
