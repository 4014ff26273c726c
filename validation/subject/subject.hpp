// SPDX-License-Identifier: MIT
#pragma once
/// Interface of a simulator under test. ModelSubject implements it with the model of this project;
/// reports/subject/foreign_subject.hpp with any simulator behind palpate_subject.h.

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/problem/scene.hpp"
#include "model/problem/trace.hpp"
#include "model/stepping/simulation.hpp"
#include "validation/subject/capabilities.hpp"

namespace palpate {

/// Input of one step: state of the hand's end of the coupling to the tool. Only scenes driven by a
/// device use it.
struct ToolInput {
  double position = 0.0;  ///< position along the tool axis [m]
  double velocity = 0.0;  ///< [m/s]
};

/// Simulator with one scene at a time.
class Subject {
 public:
  virtual ~Subject() = default;

  [[nodiscard]] virtual SubjectFacts facts() const = 0;
  /// Prepares a scene at t = 0. `network` is the tissue of the scene; empty for an oscillator. If
  /// `skip` is false, parts that the scene does not need are also computed. Throws the exceptions
  /// of the simulator.
  virtual void load(const Scene& scene, const SpringNetwork& network, bool skip) = 0;
  /// Returns to t = 0 of the loaded scene. False: the subject cannot; load() does the same.
  virtual bool reset() { return false; }
  /// Advances by one tick of the scene. If it returns `diverged`, the state is the diverged one.
  virtual StepStatus step(const std::optional<ToolInput>& input) noexcept = 0;
  /// Returns the duration of the last step as its host measured it [s]; empty: measure around
  /// step().
  [[nodiscard]] virtual std::optional<double> step_seconds() const noexcept { return {}; }
  /// Returns why the subject ended within a step: a crash, a time limit. Empty: it did not.
  [[nodiscard]] virtual std::string failure() const { return {}; }
  /// Returns the resident memory of the subject's own process; 0: it has none.
  [[nodiscard]] virtual std::size_t resident_bytes() const { return 0; }
  /// Returns the duration of an empty call to the subject [s]; 0 in process.
  virtual double round_trip() { return 0.0; }

  [[nodiscard]] virtual double time() const noexcept = 0;  ///< [s]
  [[nodiscard]] virtual long ticks() const noexcept = 0;   ///< ticks completed
  [[nodiscard]] virtual long tick_count() const noexcept = 0;
  [[nodiscard]] virtual std::string method() const = 0;     ///< name of the integration method
  [[nodiscard]] virtual int substeps() const noexcept = 0;  ///< integration steps per tick
  [[nodiscard]] virtual double step_length() const noexcept = 0;  ///< [s]

  /// Returns the names and units of the values that sample() writes.
  [[nodiscard]] virtual std::vector<Column> columns() const = 0;
  virtual void sample(std::span<double> row) noexcept = 0;
  [[nodiscard]] virtual std::vector<TextColumn> text_columns() const = 0;
  /// Appends the events since the last call to `events`.
  virtual void sample_text(std::span<std::string> row, std::vector<Event>& events) = 0;

  /// Returns the number of free coordinates, as in Trace::position.
  [[nodiscard]] virtual Eigen::Index dof() const noexcept = 0;
  virtual void coordinates(Eigen::Ref<Eigen::VectorXd> position) noexcept = 0;
  virtual void velocities(Eigen::Ref<Eigen::VectorXd> velocity) noexcept = 0;
  /// Returns false if the position or velocity of a node, fixed ones included, is not finite or far
  /// beyond any scene. Another simulator may be asked for the state of all nodes.
  [[nodiscard]] virtual bool has_finite_state() noexcept { return true; }
  /// Returns how far a fixed node is from its place [m], and how fast it is [m/s], at most.
  [[nodiscard]] virtual Eigen::Vector2d fixed_motion() noexcept { return {0.0, 0.0}; }
  [[nodiscard]] virtual double energy() noexcept = 0;  ///< [J]
  /// Returns the kinetic, elastic and dissipated energy that the subject itself reports [J]. Only
  /// with PALPATE_CAN_ENERGY.
  virtual Eigen::Vector3d reported_energy() { return Eigen::Vector3d::Zero(); }
  /// Sets positions and velocities of all nodes, 3 x nodes [m, m/s]. Only with
  /// PALPATE_CAN_SET_STATE.
  virtual void set_state(const NodeVectors& /*position*/, const NodeVectors& /*velocity*/) {}
  /// Returns the positions of all nodes [m], 3 x nodes; no columns without nodes.
  [[nodiscard]] virtual NodeVectors node_positions() = 0;
  /// Writes the positions of all nodes [m], 3 x nodes, without allocation.
  virtual void node_positions(Eigen::Ref<NodeVectors> all) noexcept = 0;

  [[nodiscard]] virtual ToolReport tool() noexcept = 0;
  [[nodiscard]] virtual ToolMotion tool_motion() const noexcept = 0;
  /// Returns the events of the tool since the last sample_text() or forget_tool_happenings().
  [[nodiscard]] virtual std::span<const ToolHappening> tool_happenings() const noexcept = 0;
  virtual void forget_tool_happenings() noexcept = 0;
};

/// Change of a material between two ticks of a run.
struct MaterialChange {
  long tick = 0;  ///< ticks completed before it
  std::size_t material = 0;
  double youngs_modulus = 0.0;  ///< from then on [Pa]
};

/// Subject that runs the model in this process.
class ModelSubject final : public Subject {
 public:
  ModelSubject() = default;
  /// Wraps a simulation that is already loaded.
  explicit ModelSubject(Simulation simulation) : simulation_(std::move(simulation)) {}

  [[nodiscard]] SubjectFacts facts() const override {
    return {.name = "palpate",
            .licence = "MIT",
            .parameters = "substeps",
            .carrier = "in process",
            .capabilities = every_capability & ~(PALPATE_CAN_OWN_DISCRETISATION |
                                                 PALPATE_CAN_SET_STATE | PALPATE_CAN_ENERGY)};
  }
  /// A step that begins with a change of a material allocates.
  void load(const Scene& scene, const SpringNetwork& network, bool skip) override;
  /// Prepares a scene with its own tissue.
  void load(const Scene& scene, bool skip);
  StepStatus step(const std::optional<ToolInput>& input) noexcept override {
    if (next_change_ < changes_.size() && changes_[next_change_].tick <= ticks()) {
      if (!change_materials()) { return StepStatus::diverged; }
    }
    if (input) { simulation_->move_handle(input->position, input->velocity); }
    return simulation_->tick();
  }
  /// Goes on with `next`, which is prepared to continue the present simulation; `next` gets the
  /// present one. Between two steps. Does not allocate.
  void exchange(Simulation& next) noexcept {
    next.continue_from(*simulation_);
    std::swap(*simulation_, next);
  }
  [[nodiscard]] std::string failure() const override { return failure_; }
  [[nodiscard]] double time() const noexcept override { return simulation_->time(); }
  [[nodiscard]] long ticks() const noexcept override { return simulation_->ticks(); }
  [[nodiscard]] long tick_count() const noexcept override { return simulation_->tick_count(); }
  [[nodiscard]] std::string method() const override {
    return std::string(simulation_->plan().integrator->name);
  }
  [[nodiscard]] int substeps() const noexcept override { return simulation_->plan().substeps; }
  [[nodiscard]] double step_length() const noexcept override { return simulation_->plan().h; }
  [[nodiscard]] std::vector<Column> columns() const override { return simulation_->columns(); }
  void sample(std::span<double> row) noexcept override { simulation_->sample(row); }
  [[nodiscard]] std::vector<TextColumn> text_columns() const override {
    return simulation_->text_columns();
  }
  void sample_text(std::span<std::string> row, std::vector<Event>& events) override {
    simulation_->sample_text(row, events);
  }
  [[nodiscard]] Eigen::Index dof() const noexcept override { return simulation_->problem().dof(); }
  void coordinates(Eigen::Ref<Eigen::VectorXd> position) noexcept override {
    simulation_->coordinates(position);
  }
  void velocities(Eigen::Ref<Eigen::VectorXd> velocity) noexcept override {
    simulation_->velocities(velocity);
  }
  [[nodiscard]] double energy() noexcept override { return simulation_->energy(); }
  [[nodiscard]] NodeVectors node_positions() override { return simulation_->node_positions(); }
  void node_positions(Eigen::Ref<NodeVectors> all) noexcept override {
    simulation_->node_positions(all);
  }
  [[nodiscard]] ToolReport tool() noexcept override { return simulation_->tool(); }
  [[nodiscard]] ToolMotion tool_motion() const noexcept override {
    return simulation_->tool_motion();
  }
  [[nodiscard]] std::span<const ToolHappening> tool_happenings() const noexcept override {
    return simulation_->tool_happenings();
  }
  void forget_tool_happenings() noexcept override { simulation_->forget_tool_happenings(); }

  [[nodiscard]] Simulation& simulation() { return *simulation_; }
  [[nodiscard]] const Simulation& simulation() const { return *simulation_; }

 private:
  /// Returns the scene without changes of its materials, which are kept for their ticks.
  const Scene& take_changes(const Scene& scene, bool skip);
  bool change_materials() noexcept;

  std::optional<Simulation> simulation_{};
  std::optional<Simulation> first_{};  ///< after a change: others may refer to its plan
  Scene scene_{};                      ///< with the present materials; only if these change
  bool skip_ = true;
  std::vector<MaterialChange> changes_{};
  std::size_t next_change_ = 0;
  std::string failure_{};
};

}  // namespace palpate
