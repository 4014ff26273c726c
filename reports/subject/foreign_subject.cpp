// SPDX-License-Identifier: MIT

#include "reports/subject/foreign_subject.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "fixtures/io/csv_file.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/scene_folder.hpp"
#include "model/problem/input_error.hpp"
#include "model/problem/needle_path.hpp"
#include "model/problem/problem.hpp"
#include "validation/number_text.hpp"

namespace palpate {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Tissue, records and tool of a scene, as a trace shows them, from the states of a subject.
class ForeignSubject final : public Subject {
 public:
  ForeignSubject(std::unique_ptr<Connection> connection, std::string options_json,
                 std::shared_ptr<const io::SceneFile> file)
      : connection_(std::move(connection)),
        options_json_(std::move(options_json)),
        file_(std::move(file)) {}

  [[nodiscard]] SubjectFacts facts() const override {
    SubjectFacts facts = connection_->facts();
    facts.sparse = true;
    return facts;
  }

  void load(const Scene& scene, const SpringNetwork& network, bool /*skip*/) override {
    const Capabilities can = facts().capabilities;
    const Capabilities needs = needs_of(scene, network);
    if (const Capabilities lacking = missing(can, scene, needs); lacking != 0) {
      throw CannotDo("the subject does not declare: " + names_of(lacking));
    }
    scene_ = scene;
    problem_.emplace(network, resolve_loads(scene, network), scene.tissue.gravity);
    const std::filesystem::path folder =
        connection_->scratch() / ("scene-" + std::to_string(++scenes_));
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directory(folder);
    folder_ = folder;
    io::write_scene_folder(folder, {.scene = scene_,
                                    .network = network,
                                    .needs = names_of(needs),
                                    .abi = PALPATE_SUBJECT_ABI,
                                    .file = file_.get()});
    try {
      connection_->load(folder, options_json_);
    } catch (const CannotDo& refusal) {
      throw Refused(std::string("the subject declares all that it needs for the scene, but: ") +
                    refusal.what() +
                    "; list a limit that no capability names in the file of --expected");
    }
    set_substeps();
    has_state_ = (can & PALPATE_CAN_STATE) != 0;
    state_.setZero(3, 2 * network.node_count());
    find_records(network);
    tool_.reset();
    path_.reset();
    if (scene.needle || scene.probe) {
      tool_.emplace(scene, network);
      path_.emplace(scene, network);
    }
    begin();
  }

  bool reset() override {
    connection_->reset(1);
    begin();
    return true;
  }

  StepStatus step(const std::optional<ToolInput>& input) noexcept override {
    if (!failure_.empty()) { return StepStatus::diverged; }
    try {
      const double t = time();
      const double dt = scene_.simulation.step;
      palpate_tool_output output = empty_output();
      const palpate_tool_input given = input_of(t, dt, input);
      double seconds = 0.0;
      const bool diverged =
          connection_->step(t, dt, tool_ ? &given : nullptr, tool_ ? &output : nullptr, seconds);
      seconds_ = seconds;
      ++ticks_;
      if (tool_) { take_output(given, output); }
      stale_ = true;
      return diverged ? StepStatus::diverged : StepStatus::ok;
    } catch (const std::exception& problem) {
      failure_ = std::string(problem.what()) + " (step at t = " + plain_number(time()) + " s)";
      return StepStatus::diverged;
    }
  }
  [[nodiscard]] std::optional<double> step_seconds() const noexcept override { return seconds_; }
  [[nodiscard]] std::string failure() const override { return failure_; }
  [[nodiscard]] std::size_t resident_bytes() const override {
    return connection_->resident_bytes();
  }
  double round_trip() override { return connection_->round_trip(); }
  Eigen::Vector3d reported_energy() override {
    Eigen::Vector3d joule;
    as_declared("energy", [&] { connection_->energy(joule.data()); });
    return joule;
  }
  void set_state(const NodeVectors& position, const NodeVectors& velocity) override {
    as_declared("set-state", [&] {
      connection_->set_state(position.data(), velocity.data(),
                             static_cast<std::size_t>(position.cols()));
    });
    stale_ = true;
    fetch();
  }

  [[nodiscard]] double time() const noexcept override {
    return static_cast<double>(ticks_) * scene_.simulation.step;
  }
  [[nodiscard]] long ticks() const noexcept override { return ticks_; }
  [[nodiscard]] long tick_count() const noexcept override {
    return std::lround(scene_.simulation.duration / scene_.simulation.step);
  }
  [[nodiscard]] std::string method() const override { return facts().name + " " + facts().version; }
  [[nodiscard]] int substeps() const noexcept override { return substeps_; }
  [[nodiscard]] double step_length() const noexcept override {
    return scene_.simulation.step / substeps_;
  }

  [[nodiscard]] std::vector<Column> columns() const override {
    std::vector<Column> columns = record_columns(scene_);
    if (tool_) {
      for (Column& column : tool_columns(scene_)) { columns.push_back(std::move(column)); }
    }
    return columns;
  }
  void sample(std::span<double> row) noexcept override {
    if (!items_.empty()) { fetch(); }
    std::size_t column = 0;
    bool forces = false;
    for (const Item& item : items_) {
      Eigen::Vector3d value = Eigen::Vector3d::Constant(nan);
      if (item.quantity == RecordedQuantity::position) { value = position(item.node); }
      if (item.quantity == RecordedQuantity::velocity) { value = velocity(item.node); }
      if (item.quantity == RecordedQuantity::force && problem_->coordinate(item.node) >= 0) {
        if (!forces) { compute_forces(); }
        forces = true;
        value = force_.segment<3>(problem_->coordinate(item.node));
      }
      for (int n = 0; n < 3; ++n) { row[column++] = has_state_ ? value(n) : nan; }
    }
    if (!tool_) { return; }
    const ToolForces& f = report_.forces;
    for (const double value :
         {report_.depth, f.total, f.cutting, f.friction, f.stiffness, f.applied}) {
      row[column++] = value;
    }
    if (scene_.syringe) {
      row[column++] = pressure_;
      row[column++] = pressure_ * scene_.syringe->plunger_area;
    }
    for (const double value : {report_.place, in_tissue_ ? report_.cut : 0.0, f.lateral}) {
      row[column++] = value;
    }
    if (scene_.probe && scene_.probe->path) {
      row[column++] = centre_.x();
      row[column++] = centre_.y();
    }
  }
  [[nodiscard]] std::vector<TextColumn> text_columns() const override {
    return tool_ ? tool_text_columns() : std::vector<TextColumn>{};
  }
  void sample_text(std::span<std::string> row, std::vector<Event>& events) override {
    if (!tool_) { return; }
    row[0] = in_tissue_ ? path_->intervals()[interval()].label : "";
    row[1].clear();
    for (const ToolHappening& happening : happenings_) {
      const std::string name(name_of(happening.event));
      row[1] += (row[1].empty() ? "" : ";") + name;
      events.push_back({happening.time, name, path_->intervals()[happening.interval].label});
    }
    happenings_.clear();
  }

  [[nodiscard]] Eigen::Index dof() const noexcept override {
    return has_state_ ? problem_->dof() : 0;
  }
  void coordinates(Eigen::Ref<Eigen::VectorXd> q) noexcept override { gather(0, q); }
  void velocities(Eigen::Ref<Eigen::VectorXd> v) noexcept override {
    gather(problem_->network().node_count(), v);
  }
  [[nodiscard]] bool has_finite_state() noexcept override {
    constexpr double most = 1e6;  // [m, m/s]; a tenth of the way around the earth
    fetch();
    return !has_state_ || stale_ || (state_.allFinite() && state_.lpNorm<Eigen::Infinity>() < most);
  }
  [[nodiscard]] Eigen::Vector2d fixed_motion() noexcept override {
    fetch();
    Eigen::Vector2d most(0.0, 0.0);
    const SpringNetwork& network = problem_->network();
    for (int node = 0; has_state_ && node < network.node_count(); ++node) {
      if (!network.is_fixed(node)) { continue; }
      const Eigen::Vector3d away = position(node) - problem_->held_position().col(node);
      most = most.cwiseMax(Eigen::Vector2d(away.norm(), velocity(node).norm()));
    }
    return most;
  }
  [[nodiscard]] double energy() noexcept override {
    if (!has_state_) { return nan; }
    read_coordinates();
    return problem_->energy(position_, velocity_);
  }
  [[nodiscard]] NodeVectors node_positions() override {
    if (!has_state_) { return problem_->held_position(); }
    fetch();
    return state_.leftCols(problem_->network().node_count());
  }
  void node_positions(Eigen::Ref<NodeVectors> all) noexcept override {
    if (!has_state_) { return; }
    fetch();
    all = state_.leftCols(all.cols());
  }
  [[nodiscard]] ToolReport tool() noexcept override { return report_; }
  [[nodiscard]] ToolMotion tool_motion() const noexcept override {
    return {report_.place, report_.velocity};
  }
  [[nodiscard]] std::span<const ToolHappening> tool_happenings() const noexcept override {
    return happenings_;
  }
  void forget_tool_happenings() noexcept override { happenings_.clear(); }

 private:
  struct Item {
    int node;
    RecordedQuantity quantity;
  };

  void find_records(const SpringNetwork& network) {
    items_.clear();
    for (const Record& record : scene_.records) {
      for (const RecordedQuantity quantity : record.quantities) {
        items_.push_back({record_node(record, network), quantity});
      }
    }
  }
  void set_substeps() {
    substeps_ = 1;
    const int wanted = scene_.simulation.substeps.value_or(1);
    if (wanted > 1 && !has_parameter(facts(), "substeps")) {
      throw CannotDo("the subject has no parameter \"substeps\", and the scene has " +
                     std::to_string(wanted) + " substeps");
    }
    if (wanted <= 1) { return; }
    as_declared("the parameter substeps", [&] {
      connection_->set_parameter("substeps", wanted);
      connection_->reset(1);
    });
    substeps_ = wanted;
  }
  /// Makes a call that the subject declares to support.
  template <class Call> static void as_declared(const char* what, Call call) {
    try {
      call();
    } catch (const CannotDo& problem) {
      throw SubjectFailure(std::string("the subject declares ") + what +
                           ", but: " + problem.what());
    }
  }
  void begin() {
    ticks_ = 0;
    failure_.clear();
    seconds_.reset();
    happenings_.clear();
    report_ = {};
    pressure_ = 0.0;
    in_tissue_ = false;
    tip_depth_ = nan;
    if (tool_) {
      report_.place = tool_->start_place();
      report_.depth = report_.place * tool_->direction().z();
      handle_ = report_.place;
      palpate_tool_output output = empty_output();
      const palpate_tool_input given = input_of(0.0, 0.0, {});
      double seconds = 0.0;
      (void)connection_->step(0.0, 0.0, &given, &output, seconds);
      take_output(given, output);
    }
    stale_ = true;
    fetch();
    if (!failure_.empty()) { throw SubjectFailure(failure_); }
  }
  /// Reads the state after a step, once it is needed. A failure ends the run at the next step.
  void fetch() noexcept {
    if (!has_state_ || !stale_ || !failure_.empty()) { return; }
    const auto nodes = static_cast<std::size_t>(problem_->network().node_count());
    try {
      as_declared("state",
                  [&] { connection_->get_state(state_.data(), state_.data() + 3 * nodes, nodes); });
      stale_ = false;
    } catch (const std::exception& problem) { failure_ = problem.what(); }
  }
  [[nodiscard]] Eigen::Vector3d position(int node) const { return state_.col(node); }
  [[nodiscard]] Eigen::Vector3d velocity(int node) const {
    return state_.col(problem_->network().node_count() + node);
  }
  void gather(Eigen::Index first, Eigen::Ref<Eigen::VectorXd> values) noexcept {
    if (!has_state_) { return; }
    fetch();
    Eigen::Index n = 0;
    for (const int node : problem_->free_nodes()) {
      values.segment<3>(n) = state_.col(first + node);
      n += 3;
    }
  }
  void read_coordinates() {
    position_.resize(problem_->dof());
    velocity_.resize(problem_->dof());
    coordinates(position_);
    velocities(velocity_);
  }
  void compute_forces() {
    read_coordinates();
    force_.resize(problem_->dof());
    problem_->force(time(), time(), position_, velocity_, force_);
  }

  [[nodiscard]] palpate_tool_input input_of(double t, double dt,
                                            const std::optional<ToolInput>& handle) {
    palpate_tool_input input{};
    if (!tool_) { return input; }
    const auto put = [](const Eigen::Vector3d& v, double* to) { std::copy_n(v.data(), 3, to); };
    put(tool_->direction(), input.direction);
    const double end = t + dt;
    double place = report_.place;
    double rate = 0.0;
    switch (tool_->kind()) {
      case Drive::Kind::trajectory:
        input.flags = PALPATE_TOOL_PRESCRIBED;
        place = tool_->place(end);
        rate = dt > 0.0 ? (place - tool_->place(t)) / dt : 0.0;
        break;
      case Drive::Kind::force:
        input.flags = PALPATE_TOOL_PUSHED;
        input.applied_force = tool_->applied_force(t);
        break;
      case Drive::Kind::falcon:
      case Drive::Kind::recorded:
        input.flags = PALPATE_TOOL_COUPLED;
        if (handle) {
          place = handle->position;
          rate = handle->velocity;
          handle_ = place;
        } else {
          place = handle_;  // the hand's end stays between two inputs
        }
        break;
    }
    input.insertion = place;
    input.insertion_rate = rate;
    const Eigen::Vector3d to = tool_->at_place(place, end);
    put(to, input.position);
    const Eigen::Vector3d travel = to - tool_->at_place(place - rate * dt, t);
    put(dt > 0.0 ? Eigen::Vector3d(travel / dt) : travel, input.velocity);
    return input;
  }

  void take_output(const palpate_tool_input& input, const palpate_tool_output& output) {
    const Eigen::Vector3d n = tool_->direction();
    const Eigen::Vector3d force(output.force[0], output.force[1], output.force[2]);
    const double before = report_.place;
    if (!force.allFinite() && !force.array().isNaN().all()) {
      throw SubjectFailure("the subject's force on the tool is [" + plain_number(force.x()) + ", " +
                           plain_number(force.y()) + ", " + plain_number(force.z()) +
                           "] N; three numbers, or three NaN without one");
    }
    report_.place = output.insertion;
    if (std::isnan(report_.place) && input.flags == PALPATE_TOOL_PRESCRIBED) {
      report_.place = input.insertion;
    }
    report_.depth = report_.place * n.z();
    report_.velocity = output.insertion_rate;
    if (std::isnan(report_.velocity)) {
      report_.velocity = (report_.place - before) / scene_.simulation.step;
    }
    report_.cut = output.cut;
    tip_depth_ = output.depth;
    const double along = -force.dot(n);
    const double parts = output.cutting + output.friction + output.stiffness;
    if (std::abs(parts - along) > 1e-6 * (std::abs(output.cutting) + std::abs(output.friction) +
                                          std::abs(output.stiffness) + std::abs(along))) {
      throw SubjectFailure("the subject's force along the tool is " + plain_number(along) +
                           " N against the insertion, but cutting, friction and stiffness sum to " +
                           plain_number(parts) + " N");
    }
    ToolForces& f = report_.forces;
    f = {.cutting = output.cutting, .friction = output.friction, .stiffness = output.stiffness};
    f.total = std::isfinite(parts) ? parts : along;
    centre_ = {input.position[0], input.position[1]};
    f.applied = std::isfinite(output.applied)        ? output.applied
                : input.flags == PALPATE_TOOL_PUSHED ? input.applied_force
                                                     : f.total;
    f.on_tool = force;
    f.lateral = force.allFinite() ? lateral_force(force, n) : nan;
    pressure_ = output.pressure;
    if (output.substeps > 0) { substeps_ = static_cast<int>(output.substeps); }
    constexpr std::uint32_t both = PALPATE_TOOL_TOUCHING | PALPATE_TOOL_APART;
    if (output.events >= 2 * PALPATE_TOOL_APART || (output.events & both) == both) {
      throw SubjectFailure("the subject reports events " + std::to_string(output.events) +
                           "; a sum of the bits 1 to 32, and of 64 or 128, is allowed");
    }
    for (unsigned bit = 0; bit < 6; ++bit) {
      if ((output.events >> bit & 1U) == 0) { continue; }
      happen(std::isfinite(output.event_time) ? output.event_time : time(),
             static_cast<ToolEvent>(bit));
    }
    if ((output.events & both) != 0) { in_tissue_ = (output.events & PALPATE_TOOL_TOUCHING) != 0; }
  }
  void happen(double t, ToolEvent event) {
    if (event == ToolEvent::contact) { in_tissue_ = true; }
    if (event == ToolEvent::withdrawn) { in_tissue_ = false; }
    happenings_.push_back({t, event, interval()});
  }
  /// Interval of the path at the tip: in front of the cut tissue that it dents.
  [[nodiscard]] std::size_t interval() const {
    if (std::isfinite(tip_depth_)) { return path_->interval_at(tip_depth_); }
    const double tip =
        std::isfinite(report_.cut) ? std::min(report_.place, report_.cut) : report_.place;
    return path_->interval_at(std::max(tip, 0.0));
  }

  std::unique_ptr<Connection> connection_;
  std::string options_json_;
  std::shared_ptr<const io::SceneFile> file_;
  std::filesystem::path folder_{};  ///< of the loaded scene
  int scenes_ = 0;                  ///< loaded so far
  Scene scene_{};
  std::optional<NetworkProblem> problem_{};
  std::vector<Item> items_{};
  std::optional<io::PrescribedTool> tool_{};
  std::optional<NeedlePath> path_{};
  bool has_state_ = false;
  bool stale_ = false;   ///< state_ is that before the last step
  NodeVectors state_{};  ///< positions of all nodes, then their velocities [m, m/s]
  Eigen::VectorXd position_{};
  Eigen::VectorXd velocity_{};
  Eigen::VectorXd force_{};
  ToolReport report_{};
  double tip_depth_ = nan;  ///< in undeformed tissue [m]
  bool in_tissue_ = false;
  Eigen::Vector2d centre_{0.0, 0.0};  ///< of a sliding probe [m]
  double handle_ = 0.0;               ///< latest position of the hand's end of the coupling [m]
  double pressure_ = 0.0;
  std::vector<ToolHappening> happenings_{};
  std::optional<double> seconds_{};
  std::string failure_{};
  int substeps_ = 1;
  long ticks_ = 0;
};

// Columns that a simulator wrote.

/// Unit at the end of a column's name, and its SI form.
struct UnitSuffix {
  std::string_view written;
  std::string_view si;
  double factor;
};
constexpr std::array unit_suffixes{UnitSuffix{"_s", "_s", 1.0},
                                   UnitSuffix{"_ms", "_s", 1e-3},
                                   UnitSuffix{"_m", "_m", 1.0},
                                   UnitSuffix{"_mm", "_m", 1e-3},
                                   UnitSuffix{"_n", "_n", 1.0},
                                   UnitSuffix{"_mn", "_n", 1e-3},
                                   UnitSuffix{"_pa", "_pa", 1.0},
                                   UnitSuffix{"_kpa", "_pa", 1e3},
                                   UnitSuffix{"_mmhg", "_pa", 133.322387415}};

/// Replays the columns of a CSV file as records and tool of a scene.
class TraceSubject final : public Subject {
 public:
  TraceSubject(const std::filesystem::path& file, const std::vector<std::string>& roles)
      : file_(file) {
    io::Problems problems;
    io::CsvTable table(file, problems);
    if (table.next_line()) {
      table.find_separator();
      table.split(table.line());
      add_columns(table, roles, problems);
      problems.throw_if_any();
      while (table.next()) { add_row(table); }
    }
    problems.throw_if_any();
    if (time_.size() < 2) {
      throw InputError(file.string() + ": fewer than two rows; a trace has one for every step");
    }
  }

  [[nodiscard]] SubjectFacts facts() const override {
    return {.name = file_.filename().string(),
            .carrier = "trace",
            .capabilities = every_capability & ~(PALPATE_CAN_STATE | PALPATE_CAN_SET_STATE |
                                                 PALPATE_CAN_ENERGY | PALPATE_CAN_REPEAT),
            .replayed = true,
            .sparse = true};
  }
  void load(const Scene& scene, const SpringNetwork& network, bool /*skip*/) override {
    (void)needs_of(scene, network);
    scene_ = scene;
    columns_ = record_columns(scene);
    if (scene.needle || scene.probe) {
      for (Column& column : tool_columns(scene)) { columns_.push_back(std::move(column)); }
    }
    source_.clear();
    for (const Column& column : columns_) {
      const auto found = std::ranges::find(read_, column.name, &Column::name);
      source_.push_back(found == read_.end() ? nullptr : &*found);
    }
    for (const Column* one : source_) {
      if (one == nullptr) { continue; }
      const auto gap =
          std::ranges::find_if_not(one->values, [](double v) { return std::isfinite(v); });
      if (gap == one->values.end()) { continue; }
      const auto row = static_cast<std::size_t>(gap - one->values.begin());
      io::refuse_file(file_, io::shown(one->name) + " is no number at " + plain_number(time_[row]) +
                                 " s; a number in every row, or no such column");
    }
    if (std::ranges::all_of(source_, [](const Column* one) { return one == nullptr; })) {
      throw CannotDo("the trace has no column of this scene" +
                     (columns_.empty() ? std::string() : ", such as " + columns_.back().name) +
                     "; --column NAME=ROLE assigns one");
    }
    const double slack = 1e-6 * scene.simulation.step;
    if (time_.back() < scene.simulation.duration - slack || time_.front() > slack) {
      throw CannotDo("the trace lasts from " + plain_number(time_.front()) + " to " +
                     plain_number(time_.back()) + " s; the scene from 0 to " +
                     plain_number(scene.simulation.duration) + " s");
    }
    ticks_ = 0;
  }
  bool reset() override {
    ticks_ = 0;
    return true;
  }
  StepStatus step(const std::optional<ToolInput>&) noexcept override {
    ++ticks_;
    return StepStatus::ok;
  }
  [[nodiscard]] std::optional<double> step_seconds() const noexcept override { return 0.0; }
  [[nodiscard]] double time() const noexcept override {
    return static_cast<double>(ticks_) * scene_.simulation.step;
  }
  [[nodiscard]] long ticks() const noexcept override { return ticks_; }
  [[nodiscard]] long tick_count() const noexcept override {
    return std::lround(scene_.simulation.duration / scene_.simulation.step);
  }
  [[nodiscard]] std::string method() const override { return file_.filename().string(); }
  [[nodiscard]] int substeps() const noexcept override { return 1; }
  [[nodiscard]] double step_length() const noexcept override { return scene_.simulation.step; }
  [[nodiscard]] std::vector<Column> columns() const override { return columns_; }
  void sample(std::span<double> row) noexcept override {
    const double t = std::clamp(time(), time_.front(), time_.back());
    const auto after = std::upper_bound(time_.begin() + 1, time_.end() - 1, t);
    const auto n = static_cast<std::size_t>(after - time_.begin());
    const double share = (t - time_[n - 1]) / (time_[n] - time_[n - 1]);
    for (std::size_t c = 0; c < row.size(); ++c) {
      const Column* source = source_[c];
      row[c] = source == nullptr
                   ? nan
                   : source->values[n - 1] + share * (source->values[n] - source->values[n - 1]);
    }
  }
  [[nodiscard]] std::vector<TextColumn> text_columns() const override { return {}; }
  void sample_text(std::span<std::string>, std::vector<Event>&) override {}
  [[nodiscard]] Eigen::Index dof() const noexcept override { return 0; }
  void coordinates(Eigen::Ref<Eigen::VectorXd>) noexcept override {}
  void velocities(Eigen::Ref<Eigen::VectorXd>) noexcept override {}
  [[nodiscard]] double energy() noexcept override { return nan; }
  [[nodiscard]] NodeVectors node_positions() override { return {}; }
  void node_positions(Eigen::Ref<NodeVectors>) noexcept override {}
  [[nodiscard]] ToolReport tool() noexcept override { return {}; }
  [[nodiscard]] ToolMotion tool_motion() const noexcept override { return {}; }
  [[nodiscard]] std::span<const ToolHappening> tool_happenings() const noexcept override {
    return {};
  }
  void forget_tool_happenings() noexcept override {}

 private:
  void add_columns(const io::CsvTable& table, const std::vector<std::string>& roles,
                   io::Problems& problems) {
    std::vector<std::string> names;
    for (const std::string_view field : table.fields()) { names.emplace_back(field); }
    for (const std::string& role : roles) {
      const auto equals = role.rfind('=');
      const auto found = std::ranges::find(names, role.substr(0, equals));
      if (equals == role.npos || found == names.end()) {
        problems.add(file_.string(), "--column " + io::shown(role) +
                                         ": no such column; NAME=ROLE with a name of the header");
        continue;
      }
      *found = role.substr(equals + 1);
    }
    for (std::string& name : names) {
      double factor = 1.0;
      for (const UnitSuffix& unit : unit_suffixes) {
        std::string lower = name;
        std::ranges::transform(lower, lower.begin(),
                               [](unsigned char c) { return std::tolower(c); });
        if (lower.size() <= unit.written.size() || !lower.ends_with(unit.written)) { continue; }
        name = name.substr(0, name.size() - unit.written.size()) + std::string(unit.si);
        factor = unit.factor;
        break;
      }
      if (std::ranges::find(read_, name, &Column::name) != read_.end()) {
        problems.add(file_.string(),
                     "two columns are " + io::shown(name) +
                         "; one is allowed: --column NAME=ROLE gives another a role");
      }
      factor_.push_back(factor);
      read_.push_back({.name = name});
    }
    const auto time = std::ranges::find(read_, "time_s", &Column::name);
    if (time == read_.end()) {
      problems.add(file_.string(), "no column time_s or time_ms; --column NAME=time_s assigns it");
      return;
    }
    time_column_ = static_cast<std::size_t>(time - read_.begin());
  }
  void add_row(io::CsvTable& table) {
    if (!table.must_have(read_.size())) { return; }
    for (std::size_t c = 0; c < read_.size(); ++c) {
      const std::optional<double> value = table.number_in(table.fields()[c]);
      read_[c].values.push_back(value.value_or(nan) * factor_[c]);
    }
    const double t = read_[time_column_].values.back();
    if (!std::isfinite(t) || (!time_.empty() && t <= time_.back())) {
      table.refuse("the time does not ascend");
    }
    time_.push_back(t);
  }

  std::filesystem::path file_;
  std::vector<Column> read_{};
  std::vector<double> factor_{};
  std::size_t time_column_ = 0;
  std::vector<double> time_{};  ///< [s]
  Scene scene_{};
  std::vector<Column> columns_{};
  std::vector<const Column*> source_{};  ///< of each column; null: not in the trace
  long ticks_ = 0;
};

}  // namespace

std::unique_ptr<Subject> make_subject(const SubjectChoice& choice,
                                      std::shared_ptr<const io::SceneFile> file) {
  if (!choice.foreign()) { return std::make_unique<ModelSubject>(); }
  constexpr std::string_view trace = "trace:";
  if (choice.subject.starts_with(trace)) {
    return std::make_unique<TraceSubject>(choice.subject.substr(trace.size()), choice.columns);
  }
  try {
    return std::make_unique<ForeignSubject>(
        connect_subject(choice.subject, choice.in_process, choice.limits), choice.options_json,
        std::move(file));
  } catch (const SubjectFailure& problem) {
    throw InputError("--subject " + io::printable(choice.subject) + ": " + problem.what());
  }
}

}  // namespace palpate
