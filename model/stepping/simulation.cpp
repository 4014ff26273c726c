// SPDX-License-Identifier: MIT

#include "model/stepping/simulation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "model/kernels/instruction_set.hpp"
#include "model/kernels/network_system.hpp"
#include "model/kernels/system.hpp"
#include "model/problem/input_error.hpp"
#include "model/problem/problem.hpp"
#include "model/problem/trace.hpp"
#include "model/stepping/integrator.hpp"
#include "model/stepping/tool_system.hpp"

namespace palpate {

/// Parts of a simulation that do not depend on its precision, and the records of its nodes.
class Simulation::Core {
 public:
  Core(const Scene& scene, std::unique_ptr<Problem> of, bool skip);
  virtual ~Core() = default;
  virtual StepStatus tick() noexcept = 0;
  [[nodiscard]] virtual Eigen::Vector3d position(int node) const noexcept = 0;  ///< [m]
  [[nodiscard]] virtual Eigen::Vector3d velocity(int node) noexcept = 0;        ///< [m/s]
  virtual void prepare_to_continue(const Core& from) = 0;
  virtual void continue_from(Core& from) noexcept = 0;
  virtual void positions(Eigen::Ref<NodeVectors> all) const noexcept = 0;  ///< of all nodes [m]
  virtual void coordinates(Eigen::Ref<Eigen::VectorXd> q) const noexcept = 0;
  virtual void velocities(Eigen::Ref<Eigen::VectorXd> v) noexcept = 0;
  virtual double energy() noexcept = 0;
  /// Returns the numbers of a spring or a cell as NetworkSystem::relaxing() does.
  [[nodiscard]] virtual int relaxing(const Spring& spring) const = 0;
  [[nodiscard]] virtual int relaxing(const VolumeCell& cell) const = 0;
  [[nodiscard]] virtual Relaxed relaxed_spring(int number) const noexcept = 0;
  [[nodiscard]] virtual Relaxed relaxed_cell(int number) const noexcept = 0;
  [[nodiscard]] virtual int zero_length_springs() const noexcept = 0;
  [[nodiscard]] virtual LimitedSteps limited_steps() const noexcept = 0;
  [[nodiscard]] virtual double awake_share() const noexcept = 0;
  [[nodiscard]] virtual std::size_t memory_bytes() const noexcept = 0;
  void sample(std::span<double> row) noexcept;
  [[nodiscard]] double time() const noexcept { return static_cast<double>(ticks) * tick_length; }

  std::unique_ptr<Problem> problem;
  const NetworkProblem* network = nullptr;  ///< the problem; null for an oscillator
  StepPlan plan;
  double tick_length = 0.0;
  long tick_count = 0;
  long ticks = 0;
  std::size_t spring_count = 1;
  ToolState* tool = nullptr;  ///< null without a tool
  std::vector<Column> columns;
  std::vector<TextColumn> text_columns;

 protected:
  /// Finds what relaxes at the recorded nodes. Allocates.
  void find_relaxing() {
    for (Item& item : items_) {
      for (const Spring& s : item.springs) { item.relaxing_springs.push_back(relaxing(s)); }
      for (const VolumeCell& cell : item.cells) { item.relaxing_cells.push_back(relaxing(cell)); }
    }
  }

 private:
  struct Item {
    int node;
    RecordedQuantity quantity;
    std::vector<Spring> springs;  ///< of the node, for its force
    std::vector<int> loads;
    std::vector<VolumeCell> cells;        ///< of the node, for its force
    std::vector<int> relaxing_springs{};  ///< number of each spring; see NetworkSystem::relaxing()
    std::vector<int> relaxing_cells{};
  };
  [[nodiscard]] Eigen::Vector3d force(const Item& item) noexcept;

  SpringLaw law_;
  std::vector<Item> items_;
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

std::vector<Column> record_columns(const Scene& scene) {
  std::vector<Column> columns;
  for (const Record& record : scene.records) {
    for (const RecordedQuantity quantity : record.quantities) {
      const QuantityColumns names = columns_of(quantity);
      for (const char* suffix : names.suffixes) {
        columns.push_back({record.name + "." + suffix, names.unit, {}});
      }
    }
  }
  return columns;
}

Simulation::Core::Core(const Scene& scene, std::unique_ptr<Problem> of, bool skip)
    : problem(std::move(of)),
      network(dynamic_cast<const NetworkProblem*>(problem.get())),
      plan(plan_steps(scene, *problem, skip)),
      tick_length(scene.simulation.step),
      tick_count(std::lround(scene.simulation.duration / tick_length)),
      law_(SpringLaw::from(scene.simulation.printed)) {
  if (network == nullptr) {
    columns = {{"x_m", "m", {}}, {"v_m_per_s", "m/s", {}}};
    return;
  }
  columns = record_columns(scene);
  for (const Record& record : scene.records) {
    const int node = record_node(record, network->network());
    for (const RecordedQuantity quantity : record.quantities) {
      Item item{node, quantity, {}, {}, {}};
      if (quantity == RecordedQuantity::force) {
        std::ranges::copy_if(network->network().springs, std::back_inserter(item.springs),
                             [&](const Spring& s) { return s.a == node || s.b == node; });
        for (std::size_t n = 0; n < network->loads().size(); ++n) {
          const auto times = std::ranges::count(network->loads()[n].nodes, node);
          for (long k = 0; k < times; ++k) { item.loads.push_back(static_cast<int>(n)); }
        }
        std::ranges::copy_if(network->network().cells, std::back_inserter(item.cells),
                             [&](const VolumeCell& cell) {
                               return cell.stiffness > 0.0 &&
                                      std::ranges::find(cell.nodes, node) != cell.nodes.end();
                             });
      }
      items_.push_back(std::move(item));
    }
  }
}

Eigen::Vector3d Simulation::Core::force(const Item& item) noexcept {
  const double t = time();
  // In the order of NetworkProblem::force, so that both give the same bits.
  Eigen::Vector3d total = Eigen::Vector3d::Zero();
  for (std::size_t n = 0; n < item.springs.size(); ++n) {
    const Spring& s = item.springs[n];
    const Eigen::Vector3d d = position(s.b) - position(s.a);
    const double length = d.norm();
    if (length < zero_length) { continue; }
    const double rate = (velocity(s.b) - velocity(s.a)).dot(d) / length;
    Eigen::Vector3d on_a = spring_force(law_, numbers_of<double>(s), d, length, rate);
    if (s.law > 0) {
      const int number = item.relaxing_springs[n];
      const Relaxed now = number >= 0 ? relaxed_spring(number) : Relaxed{};
      const double elastic = elastic_pull(network->network().law_of(s), s, length).tension;
      on_a = (now.share * elastic - now.held + s.viscosity * rate) / length * d;
    }
    total += s.a == item.node ? on_a : Eigen::Vector3d(-on_a);
  }
  for (std::size_t n = 0; n < item.cells.size(); ++n) {
    const VolumeCell& cell = item.cells[n];
    const int number = item.relaxing_cells[n];
    const Relaxed now = number >= 0 ? relaxed_cell(number) : Relaxed{};
    const RelaxedCell<double> relaxed{now.share, now.held};
    Corners<double> x{};
    Corners<double> rate{};
    Corners<double> on{};
    for (std::size_t c = 0; c < 8; ++c) {
      const Eigen::Vector3d place = position(cell.nodes[c]);
      const Eigen::Vector3d v = velocity(cell.nodes[c]);
      x[c] = {place.x(), place.y(), place.z()};
      rate[c] = {v.x(), v.y(), v.z()};
    }
    add_cell_forces<true>(CellNumbers<double>(cell), x, rate, on, &relaxed);
    for (std::size_t c = 0; c < 8; ++c) {
      if (cell.nodes[c] == item.node) { total += Eigen::Vector3d(on[c].x, on[c].y, on[c].z); }
    }
  }
  for (const int n : item.loads) {
    const Load& load = network->loads()[static_cast<std::size_t>(n)];
    total += load_factor(load, t, load_gate(t, plan.h)) * load.force;
  }
  total += network->network().mass(item.node) * network->gravity();
  return total;
}

void Simulation::Core::sample(std::span<double> row) noexcept {
  if (network == nullptr) {
    coordinates(Eigen::Map<Eigen::VectorXd>(row.data(), 1));
    velocities(Eigen::Map<Eigen::VectorXd>(row.data() + 1, 1));
    return;
  }
  std::size_t column = 0;
  for (const Item& item : items_) {
    const Eigen::Vector3d value = item.quantity == RecordedQuantity::position ? position(item.node)
                                  : item.quantity == RecordedQuantity::velocity
                                      ? velocity(item.node)
                                      : force(item);
    for (int n = 0; n < 3; ++n) { row[column++] = value(n); }
  }
  if (tool != nullptr) { tool->sample(row.subspan(column)); }
}

// Criterion for divergence of a run.

namespace {

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

/// Returns the largest coordinate [m] of a run that has not diverged: a million times the size of
/// the moving body, in addition to the initial coordinates.
double bound_of_motion(const Problem& problem) {
  const auto* network = dynamic_cast<const NetworkProblem*>(&problem);
  const double size = network != nullptr
                          ? extent_of(network->held_position())
                          : reach_of(dynamic_cast<const OscillatorProblem&>(problem).oscillator());
  return out_of_bounds * std::max(size, 1e-3);
}

/// Maximum number of times that a step without a solution is halved.
constexpr int most_step_halvings = 4;

/// Maximum number of repetitions of a step that violates the contact laws of tip or shaft.
constexpr int most_revisions = 6;

}  // namespace

template <class Real> class Simulation::CoreOf final : public Simulation::Core {
 public:
  CoreOf(const Scene& scene, std::unique_ptr<Problem> of, bool skip)
      : Core(scene, std::move(of), skip),
        update_length_(scene.simulation.printed.no_time_step ? 1.0 : plan.h),
        bound_(static_cast<Real>(bound_of_motion(*problem))) {
    if (network != nullptr) {
      add_network(scene);
    } else {
      auto made = std::make_unique<OscillatorSystem<Real>>(scene.tissue.oscillator);
      oscillator_ = made.get();
      system_ = std::move(made);
      state_ = {problem->initial_position().template cast<Real>(),
                problem->initial_velocity().template cast<Real>()};
    }
    bound_ += state_.position.template lpNorm<Eigen::Infinity>();
    integrator_ = plan.integrator->template make<Real>();
    integrator_->set_tolerance(scene.simulation.solver_tolerance,
                               scene.simulation.solver_corrections);
    integrator_->prepare(stepped(), state_, update_length_);
    if (plan.integrator->implicit && !plan.printed.any()) {
      halvings_ = most_step_halvings;
      start_ = state_;
    }
    plain_ = halvings_ == 0 && !tool_;
    if (relaxes_) { network_->remember(0.0, state_.position); }  // prepare() was about a stage
    find_relaxing();
    if (tool_) { measure_tool(); }
  }

  StepStatus tick() noexcept override {
    const FlushedDenormals flushed;
    const double begin = time();
    if (begins_) { integrator_->start(stepped(), state_, begin, update_length_); }
    begins_ = false;
    for (int n = 0; n < plan.substeps; ++n) {
      if (plain_) {
        integrator_->step(*system_, state_, begin + n * plan.h, update_length_);
      } else if (halvings_ > 0) {
        advance(begin + n * plan.h, plan.h, halvings_);
      } else {
        step_with_tool(begin + n * plan.h, plan.h);
      }
      if (relaxes_) { network_->remember(begin + (n + 1) * plan.h, state_.position); }
    }
    ++ticks;
    velocity_ = nullptr;
    elastic_energy_.reset();
    if (tool_) { measure_tool(); }
    return is_sane(state_, bound_, integrator_->most_travelled()) ? StepStatus::ok
                                                                  : StepStatus::diverged;
  }

  void prepare_to_continue(const Core& of) override {
    const auto* from = dynamic_cast<const CoreOf*>(&of);
    const char* differs = nullptr;
    if (from == nullptr || network == nullptr || from->network == nullptr) {
      differs = "the precision or the kind of the tissue";
    } else if (network->network().fixed != from->network->network().fixed ||
               network->network().rest_position != from->network->network().rest_position) {
      differs = "the nodes";
    } else if ((tool_ == nullptr) != (from->tool_ == nullptr) ||
               (tool_ && !tool_->contact.resembles(from->tool_->contact))) {
      differs = "the tool or its path";
    } else if (tick_length != from->tick_length) {
      differs = "the tick";
    }
    if (differs != nullptr) {
      throw std::invalid_argument(std::string("cannot go on from the present state: ") + differs +
                                  " would change");
    }
    network_->prepare_to_continue(*from->network_);
  }
  void continue_from(Core& of) noexcept override {
    auto& from = static_cast<CoreOf&>(of);
    const FlushedDenormals flushed;
    const Vector<Real>& q = from.state_.position;
    const Vector<Real>& v = from.velocity_now();
    const NodeLayout& old = from.network_->layout();
    const NodeLayout& layout = network_->layout();
    for (std::size_t node = 0; node < layout.first.size(); ++node) {
      if (layout.first[node] < 0 || old.first[node] < 0) { continue; }
      at_node(state_.position, layout.first[node], layout.stride) =
          at_node(q, old.first[node], old.stride);
      at_node(state_.velocity, layout.first[node], layout.stride) =
          at_node(v, old.first[node], old.stride);
    }
    if (tool_ && tool_->contact.is_coordinate()) {
      state_.position(layout.size) = q(old.size);
      state_.velocity(layout.size) = v(old.size);
    }
    network_->continue_from(*from.network_, q, v, state_);
    ticks = from.ticks;
    begins_ = true;
    velocity_ = nullptr;
    elastic_energy_.reset();
    if (!tool_) { return; }
    tool_->contact.continue_from(from.tool_->contact, state_);
    tool_->system.forget();
    measure_tool();
  }

  [[nodiscard]] Eigen::Vector3d position(int node) const noexcept override {
    return value_at(state_.position, node, [&] { return network_->moved(state_.position, node); });
  }
  void positions(Eigen::Ref<NodeVectors> all) const noexcept override {
    network_->move_all(state_.position);
    for (int node = 0; node < static_cast<int>(all.cols()); ++node) {
      all.col(node) = value_at(state_.position, node, [&] { return network_->moved(node); });
    }
  }
  [[nodiscard]] Eigen::Vector3d velocity(int node) noexcept override {
    const Vector<Real>& now = velocity_now();
    return value_at(now, node, [&] { return network_->moved(now, node); });
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
        elastic_energy_ ? network_->energy(q, v, *elastic_energy_ + network_->unmeasured_energy(q))
                        : network_->energy(q, v);
    return tool_ ? energy + tool_->contact.stored_energy() : energy;
  }
  [[nodiscard]] int relaxing(const Spring& spring) const override {
    return network_->relaxing(spring);
  }
  [[nodiscard]] int relaxing(const VolumeCell& cell) const override {
    return network_->relaxing(cell);
  }
  [[nodiscard]] Relaxed relaxed_spring(int number) const noexcept override {
    return network_->relaxed_spring(number);
  }
  [[nodiscard]] Relaxed relaxed_cell(int number) const noexcept override {
    return network_->relaxed_cell(number);
  }
  [[nodiscard]] LimitedSteps limited_steps() const noexcept override {
    return integrator_->limited_steps();
  }
  [[nodiscard]] int zero_length_springs() const noexcept override {
    return network_ != nullptr ? network_->zero_length_springs(state_.position) : 0;
  }
  [[nodiscard]] double awake_share() const noexcept override {
    return network_ != nullptr ? network_->awake_share() : 1.0;
  }
  [[nodiscard]] std::size_t memory_bytes() const noexcept override {
    const std::size_t stepping =
        bytes_of(state_.position, state_.velocity, start_.position, start_.velocity) +
        integrator_->memory_bytes();
    if (network_ == nullptr) { return stepping + sizeof(OscillatorSystem<Real>); }
    return stepping + network_->memory_bytes() + network->memory_bytes() +
           (tool_ ? tool_->system.memory_bytes() +
                        bytes_of(tool_->before.position, tool_->before.velocity, tool_->scratch)
                  : 0);
  }

 private:
  /// Needle or probe in a run.
  struct Tool {
    Tool(const Scene& scene, const NetworkProblem& problem, NetworkSystem<Real>& tissue,
         const TipCompliance& compliance)
        : contact(scene, problem, tissue.layout(), compliance), system(tissue, contact) {
      scratch.setZero(system.dof());
    }
    ToolContact<Real> contact;
    ToolSystem<Real> system;
    State<Real> before;  ///< start of a step of an implicit scheme, which may be repeated
    std::optional<typename ToolContact<Real>::Memory> memory{};  ///< at the start of a step
    Vector<Real> scratch;
  };

  void add_network(const Scene& scene) {
    auto made = make_network_system<Real>(*network, plan);
    network_ = made.get();
    system_ = std::move(made);
    spring_count = network_->spring_count();
    relaxes_ = relaxes(network->network());
    state_ = {network_->initial_position(), network_->initial_velocity()};
    if (!scene.needle && !scene.probe) { return; }
    bend_contact(scene);
    tool_ = std::make_unique<Tool>(scene, *network, *network_, plan.tip);
    tool_->contact.begin(state_);
    if (plan.integrator->implicit) { tool_->before = state_; }
    audit_ = scene.output.audit;
    tool = &tool_->contact;
    for (const Column& column : tool_columns(scene)) { columns.push_back(column); }
    text_columns = tool_text_columns();
  }
  /// Completes the laws of a contact on layers that are dented deeply: what the network's own dent
  /// leaves of the continuum's.
  void bend_contact(const Scene& scene) {
    const auto open = [](const DentTable& table) {
      return !table.dent.empty() && !table.is_complete();
    };
    if (std::ranges::none_of(plan.tip.tables, open)) { return; }
    const NeedlePath path(scene, network->network());
    std::unique_ptr<NetworkSystem<Real>> list;  // explicit schemes may have no matrices
    if (!plan.integrator->implicit) {
      if (network->free_nodes().size() > most_implicit_nodes) {
        for (const DentTable& table : plan.tip.tables) {
          if (open(table)) { plan.warnings.push_back(membrane_warning(path, table)); }
        }
        return;
      }
      StepPlan still = plan;
      still.lattice = false;
      still.integrator = find_integrator("implicit-euler");
      list = make_network_system<Real>(*network, still);
    }
    NetworkSystem<Real>& pressed = list ? *list : *network_;
    for (DentTable& table : plan.tip.tables) {
      if (!open(table)) { continue; }
      const PathInterval& layer = path.intervals()[table.interval];
      const std::size_t count = table.dent.size();
      const std::vector<double> own = dents_of_grid(pressed, path, layer.begin, table.step, count);
      const std::vector<double> at_end = dents_of_grid(
          pressed, path, layer.end, layer.cutting_force / static_cast<double>(count - 1), count);
      if (own.empty() || at_end.empty()) {
        plan.warnings.push_back(membrane_warning(path, table));
      } else {
        table.complete(layer, plan.tip.depth, plan.tip.value, own, at_end.back());
      }
    }
  }
  /// Advances from t by one implicit step of h [s], in halves if it has no solution.
  void advance(double t, double h, int halvings) noexcept {
    start_ = state_;
    if (tool_) {
      tool_->memory = tool_->contact.memory();
      step_with_tool(t, h);
    } else {
      integrator_->step(*system_, state_, t, h);
    }
    if (halvings == 0 || !std::isnan(state_.velocity(0))) { return; }
    state_ = start_;
    if (tool_) {
      tool_->contact.go_back(*tool_->memory);
      tool_->system.forget();
    }
    advance(t, 0.5 * h, halvings - 1);
    if (relaxes_) { network_->remember(t + 0.5 * h, state_.position); }
    advance(t + 0.5 * h, 0.5 * h, halvings - 1);
  }
  /// Repeats a step of an implicit scheme while it violates the contact laws of tip or shaft.
  void step_with_tool(double t, double h) noexcept {
    const bool implicit = plan.integrator->implicit;
    ToolContact<Real>& contact = tool_->contact;
    const bool changed = contact.begin_step(t, h, state_, plan.integrator->theta);
    if (changed) { tool_->system.forget(); }
    const double before = audit_ ? damping_power() : 0.0;
    const bool copied = halvings_ > 0 && !changed;  // by advance()
    if (implicit && !copied) { tool_->before = state_; }
    const State<Real>& begin = copied ? start_ : tool_->before;
    integrator_->step(tool_->system, state_, t, h);
    for (int n = 0; implicit && n < most_revisions && contact.update_active_set(state_); ++n) {
      state_ = begin;
      integrator_->step(tool_->system, state_, t, h);
    }
    if (std::isnan(state_.velocity(0))) { return; }
    if (audit_) { contact.add_damping_loss(0.5 * h * (before + damping_power())); }
    contact.end_step(t + h, state_);
  }
  /// Returns the power dissipated by the tissue's dampers [W].
  [[nodiscard]] double damping_power() noexcept {
    network_->damping(state_.position, state_.velocity, tool_->scratch);
    const Eigen::Index n = network_->layout().size;
    return std::abs(static_cast<double>(tool_->scratch.head(n).dot(state_.velocity.head(n))));
  }
  /// Returns the value of a network's node; fixed nodes keep their initial value. moved() is that
  /// of a node without coordinates.
  template <class Moved>
  [[nodiscard]] Eigen::Vector3d value_at(const Vector<Real>& all, int node,
                                         Moved moved) const noexcept {
    const NodeLayout& layout = network_->layout();
    const Eigen::Index first = layout.first[static_cast<std::size_t>(node)];
    if (first >= 0) { return at_node(all, first, layout.stride).template cast<double>(); }
    if (&all != &state_.position) { return moved(); }
    return network->network().initial_place(node) + moved();
  }
  /// Copies a vector to the order of the problem.
  void read(const Vector<Real>& from, Eigen::Ref<Eigen::VectorXd> to) const noexcept {
    if (network_ == nullptr) {
      to = from.template cast<double>();
      return;
    }
    Eigen::Index n = 0;
    network_->move_all(from);
    for (const int node : network->free_nodes()) {
      to.segment<3>(n) = value_at(from, node, [&] { return network_->moved(node); });
      n += 3;
    }
  }
  /// Returns the velocity at the current time. Staggered schemes store the velocity of another
  /// time; before the first tick the given velocity is returned.
  const Vector<Real>& velocity_now() noexcept {
    if (begins_) { return state_.velocity; }
    if (velocity_ == nullptr) { velocity_ = &integrator_->velocity_at(state_); }
    return *velocity_;
  }
  System<Real>& stepped() noexcept {
    return tool_ ? static_cast<System<Real>&>(tool_->system) : *system_;
  }
  /// Evaluates the tool's forces. A tick delivers them, so this is part of its measured time.
  void measure_tool() noexcept {
    const double t = time();
    elastic_energy_ = tool_->system.measure(t, load_gate(t, plan.h), state_.position,
                                            velocity_now(), tool_->scratch);
  }

  std::unique_ptr<System<Real>> system_;
  std::unique_ptr<Tool> tool_;
  NetworkSystem<Real>* network_ = nullptr;
  OscillatorSystem<Real>* oscillator_ = nullptr;
  std::unique_ptr<Integrator<Real>> integrator_;
  State<Real> state_;
  State<Real> start_;   ///< of an implicit step, which may be halved
  int halvings_ = 0;    ///< maximum number for a step
  bool plain_ = false;  ///< steps need no tool and no halving
  bool begins_ = true;  ///< the integrator has not started
  bool audit_ = false;
  bool relaxes_ = false;
  const Vector<Real>* velocity_ = nullptr;  ///< at the current time, if already requested
  std::optional<double> elastic_energy_;    ///< at the current time, if already requested [J]
  double update_length_ = 0.0;              ///< h, or 1 if the printed form omits the time step
  Real bound_ = 0;  ///< largest coordinate of a run that has not diverged [m]
};

void Simulation::build(const Scene& scene, std::unique_ptr<Problem> problem, bool skip) {
  for (const Material& material : scene.materials) {
    if (material.changes.empty()) { continue; }
    throw InputError("material." + material.name +
                     ".change: this command keeps the materials of a scene; must be left out");
  }
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
void Simulation::prepare_to_continue(const Simulation& from) {
  core_->prepare_to_continue(*from.core_);
}
void Simulation::continue_from(Simulation& from) noexcept { core_->continue_from(*from.core_); }
double Simulation::time() const noexcept { return core_->time(); }
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
  if (core_->tool != nullptr) { core_->tool->sample_text(row, events); }
}
ToolReport Simulation::tool() noexcept {
  return core_->tool != nullptr ? core_->tool->report() : ToolReport{};
}
void Simulation::move_handle(double place, double velocity) noexcept {
  if (core_->tool != nullptr) { core_->tool->move_handle(place, velocity); }
}
ToolMotion Simulation::tool_motion() const noexcept {
  return core_->tool != nullptr ? core_->tool->motion() : ToolMotion{};
}
std::span<const ToolHappening> Simulation::tool_happenings() const noexcept {
  return core_->tool != nullptr ? core_->tool->happenings() : std::span<const ToolHappening>{};
}
void Simulation::forget_tool_happenings() noexcept {
  if (core_->tool != nullptr) { core_->tool->clear_happenings(); }
}
void Simulation::coordinates(Eigen::Ref<Eigen::VectorXd> q) const noexcept {
  core_->coordinates(q);
}
void Simulation::velocities(Eigen::Ref<Eigen::VectorXd> v) noexcept { core_->velocities(v); }
double Simulation::energy() noexcept { return core_->energy(); }
int Simulation::zero_length_springs() const noexcept { return core_->zero_length_springs(); }
LimitedSteps Simulation::limited_steps() const noexcept { return core_->limited_steps(); }
std::size_t Simulation::spring_count() const noexcept { return core_->spring_count; }
double Simulation::awake_share() const noexcept { return core_->awake_share(); }
std::size_t Simulation::memory_bytes() const noexcept { return core_->memory_bytes(); }

void Simulation::node_positions(Eigen::Ref<NodeVectors> all) const noexcept {
  if (core_->network != nullptr) { core_->positions(all); }
}
NodeVectors Simulation::node_positions() const {
  if (core_->network == nullptr) { return {}; }
  NodeVectors all(3, core_->network->network().node_count());
  node_positions(all);
  return all;
}

}  // namespace palpate
