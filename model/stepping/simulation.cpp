// SPDX-License-Identifier: MIT
/// Columns of a scene's records, and their values at a tick. Only recorded values are computed.

#include "model/stepping/simulation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <span>
#include <vector>

#include "model/kernels/instruction_set.hpp"
#include "model/kernels/network_system.hpp"
#include "model/kernels/system.hpp"
#include "model/problem/problem.hpp"
#include "model/problem/trace.hpp"
#include "model/stepping/integrator.hpp"
#include "model/stepping/tool_system.hpp"

namespace palpate {

/// Positions and velocities of nodes at one time.
class NodeMotion {
 public:
  virtual ~NodeMotion() = default;
  [[nodiscard]] virtual Eigen::Vector3d position(int node) noexcept = 0;  ///< [m]
  [[nodiscard]] virtual Eigen::Vector3d velocity(int node) noexcept = 0;  ///< [m/s]
};

class Recorder {
 public:
  Recorder(const Scene& scene, const NetworkProblem& problem);

  [[nodiscard]] const std::vector<Column>& columns() const { return columns_; }
  void sample(double t, double gate, NodeMotion& now, std::span<double> row) const noexcept;

 private:
  struct Item {
    int node;
    RecordedQuantity quantity;
    std::vector<Spring> springs;  ///< of the node, for its force
    std::vector<int> loads;
  };
  [[nodiscard]] Eigen::Vector3d force(const Item& item, double t, double gate,
                                      NodeMotion& now) const noexcept;

  const NetworkProblem& problem_;
  SpringLaw law_;
  std::vector<Item> items_;
  std::vector<Column> columns_;
};

namespace {

struct QuantityColumns {
  std::array<const char*, 3> suffixes;
  const char* unit;
};

QuantityColumns columns_of(RecordedQuantity quantity) {
  switch (quantity) {
    case RecordedQuantity::velocity: return {{"vx_m_per_s", "vy_m_per_s", "vz_m_per_s"}, "m/s"};
    case RecordedQuantity::force: return {{"fx_n", "fy_n", "fz_n"}, "N"};
    case RecordedQuantity::position: break;
  }
  return {{"x_m", "y_m", "z_m"}, "m"};
}

}  // namespace

Recorder::Recorder(const Scene& scene, const NetworkProblem& problem)
    : problem_(problem), law_(SpringLaw::from(scene.simulation.printed)) {
  const SpringNetwork& network = problem.network();
  for (const Record& record : scene.records) {
    const int node = record_node(record, network);
    for (const RecordedQuantity quantity : record.quantities) {
      const QuantityColumns names = columns_of(quantity);
      for (const char* suffix : names.suffixes) {
        columns_.push_back({record.name + "." + suffix, names.unit, {}});
      }
      Item item{node, quantity, {}, {}};
      if (quantity == RecordedQuantity::force) {
        std::ranges::copy_if(network.springs, std::back_inserter(item.springs),
                             [&](const Spring& s) { return s.a == node || s.b == node; });
        for (std::size_t n = 0; n < problem.loads().size(); ++n) {
          const auto times = std::ranges::count(problem.loads()[n].nodes, node);
          for (long k = 0; k < times; ++k) { item.loads.push_back(static_cast<int>(n)); }
        }
      }
      items_.push_back(std::move(item));
    }
  }
}

Eigen::Vector3d Recorder::force(const Item& item, double t, double gate,
                                NodeMotion& now) const noexcept {
  const SpringNetwork& network = problem_.network();
  Eigen::Vector3d total = network.mass(item.node) * problem_.gravity();
  for (const int n : item.loads) {
    const Load& load = problem_.loads()[static_cast<std::size_t>(n)];
    total += load_factor(load, t, gate) * load.force;
  }
  for (const Spring& s : item.springs) {
    const Eigen::Vector3d d = now.position(s.b) - now.position(s.a);
    const double length = d.norm();
    if (length < zero_length) { continue; }
    const double rate = (now.velocity(s.b) - now.velocity(s.a)).dot(d) / length;
    const Eigen::Vector3d on_a =
        spring_force<double>(law_, s.stiffness, s.viscosity, s.rest_length, d, length, rate);
    total += s.a == item.node ? on_a : Eigen::Vector3d(-on_a);
  }
  return total;
}

void Recorder::sample(double t, double gate, NodeMotion& now,
                      std::span<double> row) const noexcept {
  std::size_t place = 0;
  for (const Item& item : items_) {
    const Eigen::Vector3d value =
        item.quantity == RecordedQuantity::position   ? now.position(item.node)
        : item.quantity == RecordedQuantity::velocity ? now.velocity(item.node)
                                                      : force(item, t, gate, now);
    for (int n = 0; n < 3; ++n) { row[place++] = value(n); }
  }
}

// Criterion for divergence of a run.

/// Returns the largest coordinate [m] of a run that has not diverged: a million times the size of
/// the moving body, in addition to the initial coordinates.
double bound_of_motion(const Problem& problem);

/// Returns true if a state is finite and within `bound` [m]. The sum of squares detects values that
/// are not finite; single coordinates are compared only if the sum is large or NaN. `travelled`:
/// upper bound on the displacement of any coordinate [m], if the scheme computes it.
template <class Real>
bool is_sane(const State<Real>& state, Real bound, std::optional<double> travelled) noexcept {
  if (travelled && *travelled <= static_cast<double>(bound)) { return true; }
  const bool near = state.position.squaredNorm() <= bound * bound;
  if (near && std::isfinite(state.velocity.squaredNorm())) { return true; }
  const Real far = state.position.template lpNorm<Eigen::Infinity>();
  return far <= bound && state.position.allFinite() && state.velocity.allFinite();
}

namespace {

/// Displacement in units of the body's size above which a run counts as diverged.
constexpr double out_of_bounds = 1e6;

double extent_of(const NodeVectors& place) {
  return place.cols() == 0 ? 0.0 : (place.rowwise().maxCoeff() - place.rowwise().minCoeff()).norm();
}

/// Returns the amplitude without damping [m].
double reach_of(const Oscillator& o) {
  const double omega = std::sqrt(o.stiffness / o.mass);
  if (omega > 0.0) {
    return std::abs(o.displacement) + std::abs(o.velocity) / omega +
           std::abs(o.drive_amplitude) / o.stiffness;
  }
  return std::abs(o.displacement) + std::abs(o.velocity) + std::abs(o.drive_amplitude) / o.mass;
}

}  // namespace

double bound_of_motion(const Problem& problem) {
  const auto* network = dynamic_cast<const NetworkProblem*>(&problem);
  const double size = network != nullptr
                          ? extent_of(network->held_position())
                          : reach_of(dynamic_cast<const OscillatorProblem&>(problem).oscillator());
  return out_of_bounds * std::max(size, 1e-3);
}

/// Interface of a simulation, independent of its precision.
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
  for (int node = 0; node < static_cast<int>(all.cols()); ++node) {
    all.col(node) = position(node);
  }
}

template <class Real> class Simulation::CoreOf final : public Simulation::Core {
 public:
  CoreOf(const Scene& scene, std::unique_ptr<Problem> of, bool skip) {
    problem = std::move(of);
    plan = plan_steps(scene, *problem, skip);
    tick_length = scene.simulation.step;
    tick_count = std::lround(scene.simulation.duration / tick_length);
    update_length_ = scene.simulation.printed.no_time_step ? 1.0 : plan.h;
    bound_ = static_cast<Real>(bound_of_motion(*problem));
    if (const auto* network = dynamic_cast<const NetworkProblem*>(problem.get())) {
      add_network(scene, *network);
    } else {
      add_oscillator(scene.tissue.oscillator);
    }
    state_ = network_ != nullptr
                 ? State<Real>{network_->initial_position(), network_->initial_velocity()}
                 : State<Real>{problem->initial_position().template cast<Real>(),
                               problem->initial_velocity().template cast<Real>()};
    if (tool_ != nullptr) { tool_->begin(state_); }
    bound_ += state_.position.template lpNorm<Eigen::Infinity>();
    integrator_ = plan.integrator->template make<Real>();
    integrator_->set_tolerance(scene.simulation.solver_tolerance);
    integrator_->prepare(stepped(), state_, update_length_);
    if (tool_ != nullptr) { measure_tool(); }
  }

  StepStatus tick() noexcept override {
    const FlushedDenormals flushed;
    const double begin = static_cast<double>(ticks) * tick_length;
    if (ticks == 0) { integrator_->start(stepped(), state_, 0.0, update_length_); }
    if (tool_ == nullptr) {
      for (int n = 0; n < plan.substeps; ++n) {
        integrator_->step(*system_, state_, begin + n * plan.h, update_length_);
      }
    } else {
      for (int n = 0; n < plan.substeps; ++n) {
        tool_->step(*integrator_, state_, begin + n * plan.h, plan.h);
      }
    }
    ++ticks;
    velocity_ = nullptr;
    elastic_energy_.reset();
    if (tool_ != nullptr) { measure_tool(); }
    return is_sane(state_, bound_, integrator_->most_travelled()) ? StepStatus::ok
                                                                  : StepStatus::diverged;
  }

  [[nodiscard]] Eigen::Vector3d position(int node) noexcept override {
    return value_at(state_.position, node);
  }
  [[nodiscard]] Eigen::Vector3d velocity(int node) noexcept override {
    return value_at(velocity_now(), node);
  }
  void coordinates(Eigen::Ref<Eigen::VectorXd> q) const noexcept override {
    read(state_.position, q);
  }
  void velocities(Eigen::Ref<Eigen::VectorXd> v) noexcept override { read(velocity_now(), v); }
  double energy() noexcept override {
    const Vector<Real>& q = state_.position;
    const Vector<Real>& v = velocity_now();
    if (network_ == nullptr) { return oscillator_->energy(q, v); }
    const double energy =
        elastic_energy_ ? network_->energy(q, v, *elastic_energy_) : network_->energy(q, v);
    return tool_ != nullptr ? energy + tool_->kinetic_energy() : energy;
  }
  void sample_tool(std::span<double> row) noexcept override {
    if (tool_ != nullptr) { tool_->sample(row); }
  }
  void sample_text(std::span<std::string> row, std::vector<Event>& events) override {
    if (tool_ != nullptr) { tool_->sample_text(row, events); }
  }
  ToolReport tool() noexcept override { return tool_ != nullptr ? tool_->report() : ToolReport{}; }
  void move_handle(double place, double velocity) noexcept override {
    if (tool_ != nullptr) { tool_->move_handle(place, velocity); }
  }
  [[nodiscard]] ToolMotion tool_motion() const noexcept override {
    return tool_ != nullptr ? tool_->motion() : ToolMotion{};
  }
  [[nodiscard]] std::span<const ToolHappening> tool_happenings() const noexcept override {
    return tool_ != nullptr ? tool_->happenings() : std::span<const ToolHappening>{};
  }
  void forget_tool_happenings() noexcept override {
    if (tool_ != nullptr) { tool_->forget_happenings(); }
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
    const std::size_t stepping =
        bytes_of(state_.position, state_.velocity) + integrator_->memory_bytes();
    if (network_ == nullptr) { return stepping + sizeof(OscillatorSystem<Real>); }
    return stepping + network_->memory_bytes() + (tool_ != nullptr ? tool_->memory_bytes() : 0) +
           static_cast<const NetworkProblem&>(*problem).memory_bytes();
  }

 private:
  void add_network(const Scene& scene, const NetworkProblem& network) {
    auto made = make_network_system<Real>(network, plan);
    network_ = made.get();
    system_ = std::move(made);
    recorder = std::make_unique<Recorder>(scene, network);
    columns = recorder->columns();
    if (!scene.needle && !scene.probe) { return; }
    tool_ = std::make_unique<ToolRun<Real>>(scene, network, *network_, plan.integrator->implicit);
    for (const Column& column : tool_->columns()) { columns.push_back(column); }
    text_columns = tool_->text_columns();
  }
  void add_oscillator(const Oscillator& oscillator) {
    auto made = std::make_unique<OscillatorSystem<Real>>(oscillator);
    oscillator_ = made.get();
    system_ = std::move(made);
    columns = {{"x_m", "m", {}}, {"v_m_per_s", "m/s", {}}};
  }
  /// Returns the value of a network's node; fixed nodes keep their initial value.
  [[nodiscard]] Eigen::Vector3d value_at(const Vector<Real>& all, int node) const noexcept {
    const NodeLayout& layout = network_->layout();
    const Eigen::Index first = layout.first[static_cast<std::size_t>(node)];
    if (first >= 0) { return at_node(all, first, layout.stride).template cast<double>(); }
    const Eigen::Vector3d moved = network_->moved(all, node);
    if (&all != &state_.position) { return moved; }
    return static_cast<const NetworkProblem&>(*problem).network().initial_place(node) + moved;
  }
  /// Copies a vector to the order of the problem.
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
  /// Returns the velocity at the current time. Staggered schemes store the velocity of another
  /// time; at t = 0 the given velocity is returned.
  const Vector<Real>& velocity_now() noexcept {
    if (ticks == 0) { return state_.velocity; }
    if (velocity_ == nullptr) { velocity_ = &integrator_->velocity_at(state_); }
    return *velocity_;
  }
  System<Real>& stepped() noexcept { return tool_ != nullptr ? tool_->system() : *system_; }
  /// Evaluates the tool's forces. A tick delivers them, so this is part of its measured time.
  void measure_tool() noexcept {
    const double t = static_cast<double>(ticks) * tick_length;
    elastic_energy_ = tool_->measure(t, load_gate(t, plan.h), state_, velocity_now());
  }

  std::unique_ptr<System<Real>> system_;
  std::unique_ptr<ToolRun<Real>> tool_;
  NetworkSystem<Real>* network_ = nullptr;
  OscillatorSystem<Real>* oscillator_ = nullptr;
  std::unique_ptr<Integrator<Real>> integrator_;
  State<Real> state_;
  const Vector<Real>* velocity_ = nullptr;  ///< at the current time, if already requested
  std::optional<double> elastic_energy_;    ///< at the current time, if already requested [J]
  double update_length_ = 0.0;              ///< h, or 1 if the printed form omits the time step
  Real bound_ = 0;  ///< largest coordinate of a run that has not diverged [m]
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
void Simulation::coordinates(Eigen::Ref<Eigen::VectorXd> q) const noexcept {
  core_->coordinates(q);
}
void Simulation::velocities(Eigen::Ref<Eigen::VectorXd> v) noexcept { core_->velocities(v); }
double Simulation::energy() noexcept { return core_->energy(); }
int Simulation::zero_length_springs() const noexcept { return core_->zero_length_springs(); }
std::size_t Simulation::spring_count() const noexcept { return core_->spring_count(); }
double Simulation::awake_share() const noexcept { return core_->awake_share(); }
std::size_t Simulation::memory_bytes() const noexcept { return core_->memory_bytes(); }

void Simulation::node_positions(Eigen::Ref<NodeVectors> all) noexcept {
  core_->node_positions(all);
}
NodeVectors Simulation::node_positions() const {
  const auto* network = dynamic_cast<const NetworkProblem*>(core_->problem.get());
  if (network == nullptr) { return {}; }
  NodeVectors all(3, network->network().node_count());
  core_->node_positions(all);
  return all;
}

}  // namespace palpate
