// SPDX-License-Identifier: MIT

#include "validation/roll_out.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numeric>

#include "model/problem/input_error.hpp"
#include "model/problem/problem.hpp"
#include "model/problem/rules.hpp"
#include "model/tissue/network_builder.hpp"
#include "validation/case.hpp"
#include "validation/random.hpp"
#include "validation/subject/grip_replay.hpp"

namespace palpate {

namespace {

/// Matrices without columns stay empty.
void move_columns(const NodeVectors& from, const std::vector<int>& node_of, NodeVectors& to) {
  for (Eigen::Index i = 0; i < from.cols(); ++i) {
    to.col(node_of[static_cast<std::size_t>(i)]) = from.col(i);
  }
}

}  // namespace

std::vector<int> renumber(SpringNetwork& network, Scene& scene, std::uint64_t seed) {
  const SpringNetwork first = network;
  Random random(seed);
  std::vector<int> node_of(static_cast<std::size_t>(first.node_count()));
  std::iota(node_of.begin(), node_of.end(), 0);
  random.shuffle(node_of);
  const auto to = [&](int node) { return node_of[static_cast<std::size_t>(node)]; };
  move_columns(first.rest_position, node_of, network.rest_position);
  move_columns(first.initial_displacement, node_of, network.initial_displacement);
  move_columns(first.initial_velocity, node_of, network.initial_velocity);
  for (int i = 0; i < first.node_count(); ++i) {
    network.mass(to(i)) = first.mass(i);
    network.fixed[static_cast<std::size_t>(to(i))] = first.fixed[static_cast<std::size_t>(i)];
  }
  network.springs.change_each([&](Spring& s) {
    s.a = to(s.a);
    s.b = to(s.b);
    if (random(0.0, 1.0) < 0.5) { std::swap(s.a, s.b); }
  });
  network.springs.edit([&](std::vector<Spring>& all) { random.shuffle(all); });
  for (VolumeCell& cell : network.cells) {
    for (int& node : cell.nodes) { node = to(node); }
  }
  random.shuffle(network.cells);
  for (Load& load : scene.loads) {
    for (int& node : load.nodes) { node = to(node); }
  }
  return node_of;
}

OtherOrder::OtherOrder(std::uint64_t seed, SpringNetwork& network, Scene& scene) {
  if (seed == 0 || network.node_count() == 0) { return; }
  first_ = network;
  node_of_ = renumber(network, scene, seed);
}

void OtherOrder::undo(const SpringNetwork& network, Eigen::MatrixXd& coordinates) const {
  if (node_of_.empty() || coordinates.size() == 0) { return; }
  const NetworkProblem before(first_);
  const NetworkProblem after(network);
  const Eigen::MatrixXd found = coordinates;
  for (const int node : before.free_nodes()) {
    const int there = node_of_[static_cast<std::size_t>(node)];
    coordinates.middleRows<3>(before.coordinate(node)) =
        found.middleRows<3>(after.coordinate(there));
  }
}

namespace {

using Clock = std::chrono::steady_clock;

std::array<double, 15> audit_of(const ToolReport& tool) {
  const ToolLosses& lost = tool.losses;
  const Eigen::Vector3d& on_tool = tool.forces.on_tool;
  return {tool.velocity, tool.depth,  tool.cut,    tool.slip,    tool.mass,
          on_tool.x(),   on_tool.y(), on_tool.z(), lost.cutting, lost.friction,
          lost.damping,  lost.impact, lost.jerk,   lost.impulse, lost.hand};
}

/// Writes rows and frames of a trace. Memory for all rows is reserved on construction.
class Sampler {
 public:
  /// `paced`: rows are taken between ticks in real time, which the state of all nodes may delay.
  Sampler(Subject& subject, const FalconLoop* falcon, const SampleOptions& options, bool paced,
          Trace& trace)
      : subject_(subject), falcon_(falcon), options_(options), paced_(paced), trace_(trace) {
    trace.columns = subject.columns();
    subject_columns_ = trace.columns.size();
    if (falcon != nullptr) { append(FalconLoop::columns()); }
    device_columns_ = trace.columns.size();
    if (options.tool) { append(tool_audit_columns()); }
    if (options.energy) { append({{"energy_j", "J", {}}}); }
    if (options.cells != nullptr) {
      append({{"tissue.smallest_jacobian", "1", {}}});
      all_nodes_ = subject.node_positions();
    }
    check_interval_ = std::max<long>(1, subject.tick_count() / state_checks);
    row_.resize(trace.columns.size());
    if (options.extremes) { find_extreme_columns(); }
    const auto rows =
        static_cast<std::size_t>(subject.tick_count() / options.every + 2) + extremes_.size();
    trace.text_columns = subject.text_columns();
    texts_.resize(trace.text_columns.size());
    refuse_length(rows);
    trace.time.reserve(rows);
    for (Column& column : trace.columns) { column.values.reserve(rows); }
    const auto samples = static_cast<Eigen::Index>(rows);
    if (options.position) { trace.position.resize(subject.dof(), samples); }
    if (options.velocity) { trace.velocity.resize(subject.dof(), samples); }
    reserve_frames();
  }

  /// Records the state after a tick.
  void take() {
    const double energy = is_measured_ ? subject_.energy() : 0.0;
    if (is_measured_) {
      if (subject_.ticks() == 0) { trace_.energy.initial = energy; }
      trace_.energy.final = energy;
      largest_energy_.add(energy);
      trace_.energy.maximum = largest_energy_.value();
    }
    check_state_if_due();
    const bool due =
        subject_.ticks() % options_.every == 0 || subject_.ticks() == subject_.tick_count();
    if (due || (options_.extremes && !subject_.tool_happenings().empty())) {
      sample_row(energy);
      if (finite() || trace_.time.empty()) { append_row(); }
    } else if (!extremes_.empty()) {
      sample_row(energy);
      if (finite()) { keep_extremes(); }
    }
    take_frame();
    take_keyframe();
  }

  /// Returns false if a value of the last row, or of the state at the last check, is not finite.
  /// The trace then leaves the row out, but keeps the first one.
  [[nodiscard]] bool finite() const { return finite_ && state_finite_; }

  /// Releases the unused memory of rows and frames.
  void finish() {
    for (Extreme& extreme : extremes_) { insert_row(extreme); }
    const auto samples = static_cast<Eigen::Index>(trace_.time.size());
    if (options_.position) { trace_.position.conservativeResize(Eigen::NoChange, samples); }
    if (options_.velocity) { trace_.velocity.conservativeResize(Eigen::NoChange, samples); }
    trace_.frames.time.resize(frames_taken_);
    trace_.frames.position.resize(frames_taken_);
    trace_.keyframes.time.resize(keyframes_taken_);
    trace_.keyframes.position.resize(keyframes_taken_);
    if (largest_force_ > 0.0) { insert_largest(); }
  }

 private:
  /// Refuses a trace that would not fit in memory, before the first tick. A text takes as much as
  /// four numbers.
  void refuse_length(std::size_t rows) const {
    constexpr auto most = static_cast<double>(most_trace_values);
    const double width = static_cast<double>(1 + trace_.columns.size() + 4 * texts_.size());
    const double values = static_cast<double>(rows) * width;
    if (values <= most) { return; }
    throw InputError("simulation.duration: " + number_in_words(static_cast<double>(rows)) +
                     " rows of " + number_in_words(width) + " columns are " +
                     number_in_words(values) +
                     " values; at most 1e8, by a shorter duration, a longer step, fewer records or "
                     "a longer time between rows (--every)");
  }
  void refuse_frames(std::size_t frames, Eigen::Index nodes) const {
    constexpr auto most = static_cast<double>(most_trace_values);
    const double values = 3.0 * static_cast<double>(frames) * static_cast<double>(nodes);
    if (values <= most) { return; }
    throw InputError("output.frames: " + std::to_string(frames) + " states of " +
                     std::to_string(nodes) + " nodes are " + number_in_words(values) +
                     " coordinates; at most 1e8");
  }

  void append(const std::vector<Column>& columns) {
    trace_.columns.insert(trace_.columns.end(), columns.begin(), columns.end());
  }

  void sample_row(double energy) {
    const std::span<double> row(row_);
    subject_.sample(row.first(subject_columns_));
    if (falcon_ != nullptr) {
      falcon_->sample(row.subspan(subject_columns_, device_columns_ - subject_columns_));
    }
    if (options_.tool) {
      std::ranges::copy(audit_of(subject_.tool()),
                        row_.begin() + static_cast<std::ptrdiff_t>(device_columns_));
    }
    const std::size_t last = row_.size() - 1;
    if (options_.energy) { row_[options_.cells != nullptr ? last - 1 : last] = energy; }
    if (options_.cells != nullptr) { row_[last] = jacobian_; }
    if (trace_.time.empty() && subject_.facts().sparse) {
      for (const double value : row_) { absent_.push_back(std::isnan(value)); }
    }
    finite_ = true;
    for (std::size_t n = 0; n < row_.size(); ++n) {
      finite_ = finite_ && (std::isfinite(row_[n]) || (!absent_.empty() && absent_[n]));
    }
  }

  void append_row() {
    const auto index = static_cast<Eigen::Index>(trace_.time.size());
    trace_.time.push_back(subject_.time());
    for (std::size_t n = 0; n < row_.size(); ++n) { trace_.columns[n].values.push_back(row_[n]); }
    subject_.sample_text(texts_, trace_.events);
    for (std::size_t n = 0; n < texts_.size(); ++n) {
      trace_.text_columns[n].values.push_back(texts_[n]);
    }
    if (options_.position) { subject_.coordinates(trace_.position.col(index)); }
    if (options_.velocity) { subject_.velocities(trace_.velocity.col(index)); }
  }

  /// Row of the largest value of a column, at a tick that is otherwise without a row.
  struct Extreme {
    std::size_t column = 0;
    double time = 0.0;  ///< [s]
    std::vector<double> row{};
    std::vector<std::string> texts{};
  };

  void find_extreme_columns() {
    for (std::size_t n = 0; n < trace_.columns.size(); ++n) {
      const std::string& name = trace_.columns[n].name;
      if (name == "tool.force_n" || name == "tool.insertion_m" || name == "syringe.pressure_pa") {
        extremes_.push_back({.column = n});
      }
    }
  }

  void keep_extremes() {
    for (Extreme& extreme : extremes_) {
      const double value = row_[extreme.column];
      if (!extreme.row.empty() && value <= extreme.row[extreme.column]) { continue; }
      extreme.time = subject_.time();
      extreme.row = row_;
      subject_.sample_text(texts_, trace_.events);
      extreme.texts = texts_;
    }
  }

  /// Inserts the row if its value is larger than every other of its column.
  void insert_row(const Extreme& extreme) {
    if (extreme.row.empty()) { return; }
    const std::vector<double>& values = trace_.columns[extreme.column].values;
    if (extreme.row[extreme.column] <= std::ranges::max(values)) { return; }
    const auto after = std::ranges::lower_bound(trace_.time, extreme.time) - trace_.time.begin();
    trace_.time.insert(trace_.time.begin() + after, extreme.time);
    for (std::size_t n = 0; n < extreme.row.size(); ++n) {
      std::vector<double>& column = trace_.columns[n].values;
      column.insert(column.begin() + after, extreme.row[n]);
    }
    for (std::size_t n = 0; n < extreme.texts.size(); ++n) {
      std::vector<std::string>& column = trace_.text_columns[n].values;
      column.insert(column.begin() + after, extreme.texts[n]);
    }
  }

  /// Checks nodes and cells at regular times and at the events of the tool.
  void check_state_if_due() {
    const bool ends = subject_.ticks() == 0 || subject_.ticks() == subject_.tick_count();
    const bool due = subject_.ticks() % check_interval_ == 0 || !subject_.tool_happenings().empty();
    if (!ends && !due) { return; }
    if (ends || !paced_) { state_finite_ = subject_.has_finite_state(); }
    if (options_.cells == nullptr || !state_finite_) { return; }
    subject_.node_positions(all_nodes_);
    const CellCheck check = check_cells(*options_.cells, all_nodes_);
    jacobian_ = check.smallest;
    trace_.inverted_cells = std::max(trace_.inverted_cells, check.inverted);
    if (check.smallest < trace_.smallest_jacobian) {
      trace_.smallest_jacobian = check.smallest;
      trace_.smallest_jacobian_at = subject_.time();
    }
  }

  void reserve_frames() {
    if (options_.frames <= 0 && options_.keyframes <= 0) { return; }
    const NodeVectors begin = subject_.node_positions();
    if (begin.cols() == 0) { return; }
    const long frames = std::min<long>(std::max(options_.frames, 0), subject_.tick_count() + 1);
    refuse_frames(static_cast<std::size_t>(frames), begin.cols());
    frame_interval_ =
        frames <= 1 ? 0.0
                    : static_cast<double>(subject_.tick_count()) / static_cast<double>(frames - 1);
    trace_.frames.time.resize(static_cast<std::size_t>(frames));
    trace_.frames.position.assign(trace_.frames.time.size(), begin);
    const auto force = std::ranges::find(trace_.columns, "tool.force_n", &Column::name);
    if (force == trace_.columns.end() || options_.keyframes <= 0) { return; }
    force_column_ = static_cast<std::size_t>(force - trace_.columns.begin());
    at_largest_ = begin;
    trace_.keyframes.time.resize(static_cast<std::size_t>(options_.keyframes));
    trace_.keyframes.position.assign(trace_.keyframes.time.size(), begin);
  }

  void take_frame() noexcept {
    const bool due = static_cast<double>(subject_.ticks()) >=
                     static_cast<double>(frames_taken_) * frame_interval_ - 1e-9;
    if (frames_taken_ == trace_.frames.position.size() || !due) { return; }
    trace_.frames.time[frames_taken_] = subject_.time();
    subject_.node_positions(trace_.frames.position[frames_taken_]);
    ++frames_taken_;
  }

  void take_keyframe() noexcept {
    if (trace_.keyframes.time.empty()) { return; }
    const double force = row_[force_column_];
    if (std::isfinite(force) && force > largest_force_) {
      largest_force_ = force;
      largest_time_ = subject_.time();
      subject_.node_positions(at_largest_);
    }
    if (trace_.events.size() > events_seen_ && keyframes_taken_ < trace_.keyframes.time.size()) {
      trace_.keyframes.time[keyframes_taken_] = subject_.time();
      subject_.node_positions(trace_.keyframes.position[keyframes_taken_]);
      ++keyframes_taken_;
    }
    events_seen_ = trace_.events.size();
  }

  void insert_largest() {
    Frames& frames = trace_.keyframes;
    const auto after = std::ranges::lower_bound(frames.time, largest_time_);
    if (after != frames.time.end() && *after == largest_time_) { return; }
    const auto index = after - frames.time.begin();
    frames.time.insert(after, largest_time_);
    frames.position.insert(frames.position.begin() + index, std::move(at_largest_));
  }

  Subject& subject_;
  const FalconLoop* falcon_;
  const SampleOptions& options_;
  bool paced_;
  Trace& trace_;
  bool is_measured_ = options_.energy || options_.energy_range;
  Largest largest_energy_{-unbounded};
  std::size_t subject_columns_ = 0;
  std::size_t device_columns_ = 0;  ///< with those of the subject
  std::vector<double> row_{};
  std::vector<std::string> texts_{};
  std::vector<Extreme> extremes_{};
  double frame_interval_ = 0.0;  ///< [ticks]
  std::size_t frames_taken_ = 0;
  std::size_t force_column_ = 0;
  std::size_t keyframes_taken_ = 0;
  std::size_t events_seen_ = 0;
  std::vector<bool>
      absent_{};              ///< columns that another simulator does not have: NaN from the start
  bool finite_ = true;        ///< the last row
  bool state_finite_ = true;  ///< of all nodes, at the last check
  double largest_force_ = 0.0;  ///< [N]
  double largest_time_ = 0.0;   ///< [s]
  NodeVectors at_largest_{};
  static constexpr long state_checks = 200;
  long check_interval_ = 1;  ///< [ticks]
  double jacobian_ = 1.0;    ///< of the last check
  NodeVectors all_nodes_{};
};

}  // namespace

std::vector<Column> tool_audit_columns() {
  return {{"tool.velocity_m_per_s", "m/s", {}},
          {"tool.tip_depth_m", "m", {}},
          {"tool.deepest_cut_m", "m", {}},
          {"tool.slip_m_per_s", "m/s", {}},
          {"tool.mass_kg", "kg", {}},
          {"tool.on_x_n", "N", {}},
          {"tool.on_y_n", "N", {}},
          {"tool.on_z_n", "N", {}},
          {"loss.cutting_j", "J", {}},
          {"loss.friction_j", "J", {}},
          {"loss.damping_j", "J", {}},
          {"loss.impact_j", "J", {}},
          {"loss.impact_hand_j", "J", {}},
          {"loss.impulse_ns", "N s", {}},
          {"loss.hand_j", "J", {}}};
}

Trace roll_out(Subject& subject, const Scene& scene, const SampleOptions& options,
               const RunControl& control) {
  std::optional<FalconLoop> falcon;
  if (scene.drive && scene.drive->kind == Drive::Kind::falcon) {
    falcon.emplace(scene, subject, control.device);
    falcon->follow(control.clock);
  }
  Trace trace;
  trace.method = subject.method();
  trace.substeps = subject.substeps();
  trace.h = subject.step_length();
  GripReplay replay(scene);
  Sampler sampler(subject, falcon ? &*falcon : nullptr, options, control.clock != nullptr, trace);
  sampler.take();
  trace.diverged = !sampler.finite();
  const long count = subject.tick_count();
  auto last_progress = Clock::now();
  while (trace.ticks < count && !trace.diverged) {
    if (control.stop != nullptr && control.stop->load(std::memory_order_relaxed)) {
      trace.interrupted = true;
      break;
    }
    double due = 0.0;
    if (control.clock != nullptr && !falcon) { due = control.clock->wait(); }
    const double slept = control.clock != nullptr ? control.clock->facts().slept : 0.0;
    const double start = control.clock != nullptr ? control.clock->now() : 0.0;
    const auto begin = Clock::now();
    const TickOrder order =
        control.hook != nullptr ? control.hook->before_tick(subject) : TickOrder{};
    if (order.what == TickOrder::What::end) { break; }
    const bool steps = order.what == TickOrder::What::step;
    const auto step = [&] {
      const std::optional<ToolInput> recorded = replay.at(subject.time() + scene.simulation.step);
      return subject.step(order.input ? order.input : recorded);
    };
    const StepStatus status = !steps ? StepStatus::ok : falcon ? falcon->tick() : step();
    if (control.hook != nullptr) {
      const bool paced = control.clock != nullptr;
      control.hook->after_tick(
          subject,
          {.due = paced ? due : start, .begin = start, .end = paced ? control.clock->now() : start},
          steps);
    }
    if (!steps) { continue; }
    const auto end = Clock::now();
    const double waited = control.clock != nullptr ? control.clock->facts().slept - slept : 0.0;
    const double seconds = subject.step_seconds().value_or(
        std::chrono::duration<double>(end - begin).count() - waited);
    trace.seconds += seconds;
    trace.slowest_tick = std::max(trace.slowest_tick, seconds);
    trace.steps += trace.substeps;
    ++trace.ticks;
    if (status == StepStatus::diverged) {
      trace.diverged = true;
      trace.diverged_at = subject.time();
    } else {
      sampler.take();
      if (!sampler.finite()) {
        trace.diverged = true;
        trace.diverged_at = subject.time();
      }
      if (control.enough && control.enough(trace)) { break; }
    }
    if (control.progress && end - last_progress > std::chrono::milliseconds(250)) {
      control.progress(static_cast<double>(trace.ticks) / static_cast<double>(count));
      last_progress = end;
    }
  }
  if (const std::string failure = subject.failure(); !failure.empty()) {
    // An interrupt ends the call of a subject that does not answer.
    if (control.stop == nullptr || !control.stop->load()) { throw SubjectFailure(failure); }
    trace.diverged = false;
    trace.interrupted = true;
  }
  sampler.finish();
  if (falcon && control.falcon != nullptr) { *control.falcon = falcon->facts(); }
  return trace;
}

Trace roll_out(const CaseContext& context, Scene scene, const SpringNetwork* network,
               const SampleOptions& options, RunControl control) {
  SpringNetwork tissue = network != nullptr                          ? *network
                         : scene.tissue.source == Source::oscillator ? SpringNetwork{}
                                                                     : build_network(scene);
  const Mutation none;
  const Mutation& mutation = context.mutation != nullptr ? *context.mutation : none;
  if (mutation.model) { mutation.model(scene, tissue); }
  if (mutation.step_twice) {
    scene.simulation.step *= 2.0;
    scene.simulation.duration *= 2.0;
  }
  control.device.extra_delay += mutation.loop_delay;
  const bool has_tool = scene.needle || scene.probe;
  const OtherOrder order(has_tool ? 0 : context.order, tissue, scene);
  const std::unique_ptr<Subject> subject = context.make_subject();
  subject->load(scene, tissue, context.skip);
  Trace trace = roll_out(*subject, scene, options, control);
  order.undo(tissue, trace.position);
  order.undo(tissue, trace.velocity);
  if (mutation.step_twice) {
    for (double& t : trace.time) { t *= 0.5; }
    for (Event& event : trace.events) { event.time *= 0.5; }
  }
  if (mutation.trace) { mutation.trace(trace); }
  return trace;
}

Scene scene_of(const std::string& integrator, double step, double duration, int substeps) {
  Scene scene;
  scene.simulation.integrator = integrator;
  scene.simulation.step = step;
  scene.simulation.duration = duration;
  scene.simulation.substeps = substeps;
  scene.tissue.source = Source::network;
  return scene;
}

Scene s26_scene(int nodes) {
  Scene scene = scene_of("euler-cromer", 1e-3, 0.1);
  scene.title = "S26, " + std::to_string(nodes) + " nodes a side";
  scene.tissue.source = Source::lattice;
  scene.tissue.fixed = std::vector<Face>{Face::z_min};
  scene.tissue.lattice = {.nodes = {nodes, nodes, nodes},
                          .spacing = 0.01,
                          .weights = LatticeWeights::uniform,
                          .stiffness = 50.0,
                          .viscosity = 0.05,
                          .node_mass = 1e-3};
  const int middle = ((nodes - 1) * nodes + nodes / 2) * nodes + nodes / 2;
  scene.loads = {{.nodes = {middle}, .force = {0.0, 0.0, 0.1}}};
  scene.records = {{.name = "tip", .where = middle, .quantities = {RecordedQuantity::position}}};
  return scene;
}

}  // namespace palpate
