// SPDX-License-Identifier: MIT
#include "model/stepping/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "model/dynamics/network_builder.hpp"
#include "model/dynamics/syringe.hpp"
#include "model/stepping/flushed_denormals.hpp"
#include "model/stepping/network_system.hpp"
#include "model/stepping/oscillator_system.hpp"
#include "model/stepping/pushes.hpp"
#include "model/stepping/recorder.hpp"
#include "model/stepping/tool_system.hpp"

namespace palpate {

namespace {

/// Motion further than this many times the body's own size is divergence.
constexpr double out_of_bounds = 1e6;
/// How often a step is taken again because tip or shaft broke their laws in it.
constexpr int most_revisions = 6;

double bound_of(const Problem& problem) {
  if (const auto* network = dynamic_cast<const NetworkProblem*>(&problem)) {
    const NodeVectors& place = network->held_position();
    const double extent =
        place.cols() == 0 ? 0.0 : (place.rowwise().maxCoeff() - place.rowwise().minCoeff()).norm();
    return out_of_bounds * std::max(extent, 1e-3);
  }
  const Oscillator& o = dynamic_cast<const OscillatorProblem&>(problem).oscillator();
  const double omega = std::sqrt(o.stiffness / o.mass);
  const double reach = std::abs(o.displacement) +
                       (omega > 0.0 ? std::abs(o.velocity) / omega +
                                          std::abs(o.drive_amplitude) / o.stiffness
                                    : std::abs(o.velocity) + std::abs(o.drive_amplitude) / o.mass);
  return out_of_bounds * std::max(reach, 1e-3);
}

/// Nodes that a tool may push.
std::vector<int> nodes_of_tool(const Scene& scene, const SpringNetwork& network) {
  std::vector<int> nodes;
  if (!scene.needle && !scene.probe) { return nodes; }
  const NeedlePath path = tool_path(scene, network);
  for (const NeedlePath::Knot& knot : path.knots()) {
    for (const NeedlePath::Support& support : path.supports(knot)) { nodes.push_back(support.node); }
  }
  return nodes;
}

}  // namespace

/// Hides the precision.
class Simulation::Core : public NodeMotion {
 public:
  virtual StepStatus tick() noexcept = 0;
  virtual void coordinates(Eigen::Ref<Eigen::VectorXd> q) const noexcept = 0;
  virtual void velocities(Eigen::Ref<Eigen::VectorXd> v) noexcept = 0;
  virtual double energy() noexcept = 0;
  [[nodiscard]] virtual int zero_length_springs() const noexcept = 0;
  [[nodiscard]] virtual std::size_t spring_count() const noexcept = 0;
  [[nodiscard]] virtual double awake_share() const noexcept = 0;
  [[nodiscard]] virtual std::size_t memory_bytes() const noexcept = 0;
  void sample(std::span<double> row) noexcept;
  void node_positions(Eigen::Ref<NodeVectors> all) noexcept;
  virtual void sample_tool(std::span<double> row) noexcept = 0;
  virtual void sample_text(std::span<std::string> row, std::vector<Event>& events) = 0;
  virtual ToolReport tool() noexcept = 0;
  virtual void move_handle(double place, double velocity) noexcept = 0;
  [[nodiscard]] virtual ToolMotion tool_motion() const noexcept = 0;
  [[nodiscard]] virtual std::span<const ToolHappening> tool_happenings() const noexcept = 0;
  virtual void forget_tool_happenings() noexcept = 0;

  std::unique_ptr<Problem> problem;
  StepPlan plan;
  double tick_length = 0.0;
  long tick_count = 0;
  long ticks = 0;
  std::unique_ptr<Recorder> recorder;
  std::vector<Column> columns;
  std::vector<TextColumn> text_columns;

};

void Simulation::Core::sample(std::span<double> row) noexcept {
  if (recorder == nullptr) {
    coordinates(Eigen::Map<Eigen::VectorXd>(row.data(), 1));
    velocities(Eigen::Map<Eigen::VectorXd>(row.data() + 1, 1));
    return;
  }
  const double t = static_cast<double>(ticks) * tick_length;
  recorder->sample(t, load_gate(t, plan.h), *this, row);
  sample_tool(row.subspan(recorder->columns().size()));
}

void Simulation::Core::node_positions(Eigen::Ref<NodeVectors> all) noexcept {
  for (int node = 0; node < static_cast<int>(all.cols()); ++node) { all.col(node) = position(node); }
}

template <class Real>
class Simulation::CoreOf final : public Simulation::Core {
 public:
  CoreOf(const Scene& scene, std::unique_ptr<Problem> of, bool skip) {
    problem = std::move(of);
    plan = plan_steps(scene, *problem, skip);
    tick_length = scene.simulation.step;
    tick_count = std::lround(scene.simulation.duration / tick_length);
    const PrintedForm& printed = scene.simulation.printed;
    update_length_ = printed.no_time_step ? 1.0 : plan.h;
    bound_ = static_cast<Real>(bound_of(*problem));
    if (const auto* network = dynamic_cast<const NetworkProblem*>(problem.get())) {
      std::optional<FarFieldSetting> far;
      if (plan.near) {
        far = {.near = *plan.near, .pushes = pushes_of(scene, *network), .modes = scene.simulation.far_modes};
      }
      auto made = make_network_system<Real>(
          *network,
          {.printed = printed, .h = plan.h, .lattice = plan.lattice, .matrices = plan.integrator->implicit,
           .threads = plan.threads, .sleep_force = plan.sleep_force,
           .touched = plan.sleep_force > 0.0 ? nodes_of_tool(scene, network->network()) : std::vector<int>{},
           .skip = skip,
           .far = std::move(far)});
      network_ = made.get();
      system_ = std::move(made);
      recorder = std::make_unique<Recorder>(scene, *network);
      columns = recorder->columns();
      if (scene.needle || scene.probe) { add_tool(scene, *network); }
    } else {
      auto made = std::make_unique<OscillatorSystem<Real>>(scene.tissue.oscillator);
      oscillator_ = made.get();
      system_ = std::move(made);
      columns = {{"x_m", "m", {}}, {"v_m_per_s", "m/s", {}}};
    }
    state_ = network_ != nullptr
                 ? State<Real>{network_->initial_position(), network_->initial_velocity()}
                 : State<Real>{problem->initial_position().template cast<Real>(),
                               problem->initial_velocity().template cast<Real>()};
    if (contact_ != nullptr) { put_tool_in_place(); }
    bound_ += state_.position.template lpNorm<Eigen::Infinity>();
    if (contact_ != nullptr && plan.integrator->implicit) { before_ = state_; }
    integrator_ = plan.integrator->template make<Real>();
    integrator_->set_tolerance(scene.simulation.solver_tolerance);
    integrator_->prepare(stepped(), state_, update_length_);
    if (contact_ != nullptr) { measure_tool(); }
  }

  StepStatus tick() noexcept override {
    const FlushedDenormals flushed;
    const double begin = static_cast<double>(ticks) * tick_length;
    if (ticks == 0) { integrator_->start(stepped(), state_, 0.0, update_length_); }
    if (contact_ == nullptr) {
      for (int n = 0; n < plan.substeps; ++n) {
        integrator_->step(*system_, state_, begin + n * plan.h, update_length_);
      }
    } else {
      for (int n = 0; n < plan.substeps; ++n) { step_with_tool(begin + n * plan.h); }
    }
    ++ticks;
    velocity_ = nullptr;
    elastic_energy_.reset();
    if (contact_ != nullptr) { measure_tool(); }
    return is_sane() ? StepStatus::ok : StepStatus::diverged;
  }

  [[nodiscard]] Eigen::Vector3d position(int node) noexcept override { return value_at(state_.position, node); }
  [[nodiscard]] Eigen::Vector3d velocity(int node) noexcept override { return value_at(velocity_now(), node); }
  void coordinates(Eigen::Ref<Eigen::VectorXd> q) const noexcept override {
    read(state_.position, q);
  }
  void velocities(Eigen::Ref<Eigen::VectorXd> v) noexcept override {
    read(velocity_now(), v);
  }
  double energy() noexcept override {
    const Vector<Real>& q = state_.position;
    const Vector<Real>& v = velocity_now();
    if (network_ == nullptr) { return oscillator_->energy(q, v); }
    double energy = elastic_energy_ ? network_->energy(q, v, *elastic_energy_) : network_->energy(q, v);
    if (contact_ != nullptr && contact_->is_coordinate()) {
      energy += 0.5 * contact_->mass() * contact_->velocity() * contact_->velocity();
    }
    return energy;
  }
  void sample_tool(std::span<double> row) noexcept override {
    if (contact_ == nullptr) { return; }
    const ToolForces& f = contact_->forces();
    std::size_t place = 0;
    for (const double value : {contact_->place() * contact_->path().direction().z(), f.total,
                               f.cutting, f.friction, f.stiffness, f.applied}) {
      row[place++] = value;
    }
    if (syringe_) {
      row[place++] = syringe_->pressure();
      row[place++] = syringe_->thumb();
    }
    row[place++] = contact_->place();
    row[place++] = contact_->in_tissue() ? contact_->cut() : 0.0;
    row[place++] = f.lateral;
  }
  void sample_text(std::span<std::string> row, std::vector<Event>& events) override {
    if (contact_ == nullptr) { return; }
    row[0] = contact_->in_tissue() ? contact_->interval().label : "";
    row[1].clear();
    for (const ToolHappening& happening : contact_->happenings()) {
      const std::string name(name_of(happening.event));
      row[1] += (row[1].empty() ? "" : ";") + name;
      events.push_back({happening.time, name, contact_->path().intervals()[happening.interval].label});
    }
    contact_->clear_happenings();
  }
  ToolReport tool() noexcept override {
    if (contact_ == nullptr) { return {}; }
    ToolLosses losses = contact_->losses();
    losses.damping = damped_;
    return {contact_->place(), contact_->velocity(), contact_->depth(),  contact_->cut(),
            contact_->slip(),  contact_->mass(),     contact_->forces(), losses};
  }
  void move_handle(double place, double velocity) noexcept override {
    if (contact_ != nullptr) { contact_->move_handle(place, velocity); }
  }
  [[nodiscard]] ToolMotion tool_motion() const noexcept override {
    if (contact_ == nullptr) { return {}; }
    return {contact_->place(), contact_->velocity()};
  }
  [[nodiscard]] std::span<const ToolHappening> tool_happenings() const noexcept override {
    if (contact_ == nullptr) { return {}; }
    return contact_->happenings();
  }
  void forget_tool_happenings() noexcept override {
    if (contact_ != nullptr) { contact_->clear_happenings(); }
  }
  [[nodiscard]] int zero_length_springs() const noexcept override {
    return network_ != nullptr ? network_->zero_length_springs(state_.position) : 0;
  }
  [[nodiscard]] std::size_t spring_count() const noexcept override {
    return network_ != nullptr ? network_->spring_count() : 1;
  }
  [[nodiscard]] double awake_share() const noexcept override {
    return network_ != nullptr ? network_->awake_share() : 1.0;
  }
  [[nodiscard]] std::size_t memory_bytes() const noexcept override {
    const std::size_t stepping = bytes_of(state_.position, state_.velocity, before_.position,
                                          before_.velocity, scratch_) +
                                 integrator_->memory_bytes();
    if (network_ == nullptr) { return stepping + sizeof(OscillatorSystem<Real>); }
    return stepping + network_->memory_bytes() + (with_tool_ != nullptr ? with_tool_->memory_bytes() : 0) +
           static_cast<const NetworkProblem&>(*problem).memory_bytes();
  }

 private:
  /// Of a network's node; fixed ones stay.
  [[nodiscard]] Eigen::Vector3d value_at(const Vector<Real>& all, int node) const noexcept {
    const NodeLayout& layout = network_->layout();
    const Eigen::Index first = layout.first[static_cast<std::size_t>(node)];
    if (first >= 0) { return at_node(all, first, layout.stride).template cast<double>(); }
    const Eigen::Vector3d moved = network_->moved(all, node);
    if (&all != &state_.position) { return moved; }
    return static_cast<const NetworkProblem&>(*problem).network().initial_place(node) + moved;
  }
  /// In the problem's order.
  void read(const Vector<Real>& from, Eigen::Ref<Eigen::VectorXd> to) const noexcept {
    if (network_ == nullptr) {
      to = from.template cast<double>();
      return;
    }
    Eigen::Index n = 0;
    for (const int node : static_cast<const NetworkProblem&>(*problem).free_nodes()) {
      to.segment<3>(n) = value_at(from, node);
      n += 3;
    }
  }
  /// Staggered schemes carry another instant's velocity; the one of t = 0 is the given one.
  const Vector<Real>& velocity_now() noexcept {
    if (ticks == 0) { return state_.velocity; }
    if (velocity_ == nullptr) { velocity_ = &integrator_->velocity_at(state_); }
    return *velocity_;
  }
  /// A sum of squares cannot hide what is not finite, and is quick; only a large one, or one that is no
  /// number, asks for a closer look.
  [[nodiscard]] bool is_sane() const noexcept {
    const std::optional<double> travelled = integrator_->most_travelled();
    if (travelled && *travelled <= static_cast<double>(bound_)) { return true; }
    const bool near = state_.position.squaredNorm() <= bound_ * bound_;
    if (near && std::isfinite(state_.velocity.squaredNorm())) { return true; }
    const Real far = state_.position.template lpNorm<Eigen::Infinity>();
    return far <= bound_ && state_.position.allFinite() && state_.velocity.allFinite();
  }

  void add_tool(const Scene& scene, const NetworkProblem& network) {
    contact_ = std::make_unique<ToolContact<Real>>(scene, network, network_->layout());
    with_tool_ = std::make_unique<ToolSystem<Real>>(*network_, *contact_);
    if (scene.syringe) { syringe_.emplace(*scene.syringe); }
    scratch_.setZero(with_tool_->dof());
    audit_ = scene.output.audit;
    const auto add = [this](const char* name, const char* unit) { columns.push_back({name, unit, {}}); };
    add("tool.depth_m", "m");
    for (const char* name : {"tool.force_n", "tool.cutting_n", "tool.friction_n",
                             "tool.stiffness_n", "tool.applied_n"}) {
      add(name, "N");
    }
    if (syringe_) {
      add("syringe.pressure_pa", "Pa");
      add("syringe.thumb_n", "N");
    }
    add("tool.insertion_m", "m");
    add("tool.cut_m", "m");
    add("tool.lateral_n", "N");
    text_columns = {{"tool.layer", {}}, {"tool.event", {}}};
  }
  void put_tool_in_place() {
    if (contact_->is_coordinate()) {
      const Eigen::Index last = state_.position.size();
      state_.position.conservativeResize(last + 1);
      state_.velocity.conservativeResize(last + 1);
      state_.position(last) = static_cast<Real>(contact_->initial_place());
      state_.velocity(last) = Real(0);
    }
    contact_->begin(state_);
  }
  System<Real>& stepped() noexcept {
    return with_tool_ != nullptr ? static_cast<System<Real>&>(*with_tool_) : *system_;
  }
  void step_with_tool(double t) noexcept {
    if (contact_->begin_step(t, plan.h, state_, plan.integrator->implicit)) { with_tool_->forget(); }
    const double before = audit_ ? damping_power() : 0.0;
    if (plan.integrator->implicit) { before_ = state_; }
    integrator_->step(*with_tool_, state_, t, plan.h);
    for (int n = 0; plan.integrator->implicit && n < most_revisions && contact_->revise(state_); ++n) {
      state_ = before_;
      integrator_->step(*with_tool_, state_, t, plan.h);
    }
    if (audit_) { damped_ += 0.5 * plan.h * (before + damping_power()); }
    contact_->end_step(t + plan.h, state_);
    if (syringe_) {
      syringe_->advance(plan.h, contact_->in_tissue(), contact_->interval().role);
    }
  }
  /// What the tissue's dampers take now [W].
  double damping_power() noexcept {
    network_->damping(state_.position, state_.velocity, scratch_);
    const Eigen::Index n = network_->layout().size;
    return std::abs(static_cast<double>(scratch_.head(n).dot(state_.velocity.head(n))));
  }
  /// Forces at the present state, not at the last stage of a step: what a tick is there for, so it is part
  /// of the tick's time.
  void measure_tool() noexcept {
    const double t = static_cast<double>(ticks) * tick_length;
    elastic_energy_ =
        with_tool_->measure(t, load_gate(t, plan.h), state_.position, velocity_now(), scratch_);
  }

  std::unique_ptr<System<Real>> system_;
  std::unique_ptr<ToolContact<Real>> contact_;
  std::unique_ptr<ToolSystem<Real>> with_tool_;
  std::optional<SyringePressure> syringe_;
  Vector<Real> scratch_;
  bool audit_ = false;
  double damped_ = 0.0;  ///< [J]
  NetworkSystem<Real>* network_ = nullptr;
  OscillatorSystem<Real>* oscillator_ = nullptr;
  std::unique_ptr<Integrator<Real>> integrator_;
  State<Real> state_;
  State<Real> before_;  ///< the step that may be taken again
  const Vector<Real>* velocity_ = nullptr;  ///< of the present instant, once it was asked for
  std::optional<double> elastic_energy_;    ///< likewise [J]
  double update_length_ = 0.0;  ///< h, or 1 where the printed form leaves the time step out
  Real bound_ = 0;  ///< of a coordinate that has not diverged [m]
};

void Simulation::build(const Scene& scene, std::unique_ptr<Problem> problem, bool skip) {
  if (scene.simulation.precision == Precision::single_precision) {
    core_ = std::make_unique<CoreOf<float>>(scene, std::move(problem), skip);
  } else {
    core_ = std::make_unique<CoreOf<double>>(scene, std::move(problem), skip);
  }
}

Simulation::Simulation(const Scene& scene, bool skip) { build(scene, make_problem(scene), skip); }

Simulation::Simulation(const Scene& scene, const SpringNetwork& network, bool skip) {
  build(scene,
        std::make_unique<NetworkProblem>(network, resolve_loads(scene, network),
                                         scene.tissue.gravity, scene.simulation.printed),
        skip);
}

Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

StepStatus Simulation::tick() noexcept { return core_->tick(); }
double Simulation::time() const noexcept {
  return static_cast<double>(core_->ticks) * core_->tick_length;
}
long Simulation::ticks() const noexcept { return core_->ticks; }
long Simulation::tick_count() const noexcept { return core_->tick_count; }
const StepPlan& Simulation::plan() const noexcept { return core_->plan; }
const Problem& Simulation::problem() const noexcept { return *core_->problem; }
const std::vector<Column>& Simulation::columns() const noexcept { return core_->columns; }
void Simulation::sample(std::span<double> row) noexcept { core_->sample(row); }
const std::vector<TextColumn>& Simulation::text_columns() const noexcept {
  return core_->text_columns;
}
void Simulation::sample_text(std::span<std::string> row, std::vector<Event>& events) {
  core_->sample_text(row, events);
}
ToolReport Simulation::tool() noexcept { return core_->tool(); }
void Simulation::move_handle(double place, double velocity) noexcept {
  core_->move_handle(place, velocity);
}
ToolMotion Simulation::tool_motion() const noexcept { return core_->tool_motion(); }
std::span<const ToolHappening> Simulation::tool_happenings() const noexcept {
  return core_->tool_happenings();
}
void Simulation::forget_tool_happenings() noexcept { core_->forget_tool_happenings(); }
void Simulation::coordinates(Eigen::Ref<Eigen::VectorXd> q) const noexcept { core_->coordinates(q); }
void Simulation::velocities(Eigen::Ref<Eigen::VectorXd> v) noexcept { core_->velocities(v); }
double Simulation::energy() noexcept { return core_->energy(); }
int Simulation::zero_length_springs() const noexcept { return core_->zero_length_springs(); }
std::size_t Simulation::spring_count() const noexcept { return core_->spring_count(); }
double Simulation::awake_share() const noexcept { return core_->awake_share(); }
std::size_t Simulation::memory_bytes() const noexcept { return core_->memory_bytes(); }

void Simulation::node_positions(Eigen::Ref<NodeVectors> all) noexcept { core_->node_positions(all); }
NodeVectors Simulation::node_positions() const {
  const auto* network = dynamic_cast<const NetworkProblem*>(core_->problem.get());
  if (network == nullptr) { return {}; }
  NodeVectors all(3, network->network().node_count());
  core_->node_positions(all);
  return all;
}

}  // namespace palpate
