// SPDX-License-Identifier: MIT

#include "reports/live/live_loop.hpp"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <pthread.h>

#include "fixtures/io/csv_file.hpp"
#include "model/tissue/network_builder.hpp"
#include "reports/live/frame_codec.hpp"

namespace palpate::live {

namespace {

constexpr int most_commands_per_tick = 16;
constexpr double grip_pulsation = 60.0;  // of the settling grip [rad/s]: it lags by 33 ms
constexpr double pointer_speed = 0.25;   // limit on a grip that follows a pointer [m/s]
constexpr double fastest_drive = 0.25;   // [m/s]
constexpr double least_factor = 0.05;    // of Young's modulus
constexpr double most_factor = 20.0;
constexpr auto between_looks = std::chrono::milliseconds(10);

double value_in(const std::vector<double>& row, int column) {
  return column < 0 ? 0.0 : row[static_cast<std::size_t>(column)];
}

}  // namespace

std::uint64_t Snapshot::sum() const noexcept {
  const auto numbers = std::bit_cast<std::array<double, sizeof(LiveState) / sizeof(double)>>(state);
  return live::checksum({position.data(), static_cast<std::size_t>(position.size())},
                        live::checksum(numbers, 1));
}

void Grip::place_at(double position) noexcept {
  target_ = intent_ = position_ = position;
  velocity_ = 0.0;
}

ToolInput Grip::advance(double dt) noexcept {
  const double way = (pointed_ ? pointer_speed : speed_) * dt;
  intent_ += std::clamp(target_ - intent_, -way, way);
  // Exact solution of the critically damped oscillator over dt for a resting intent.
  const double offset = position_ - intent_;
  const double decay = std::exp(-grip_pulsation * dt);
  const double rate = velocity_ + grip_pulsation * offset;
  position_ = intent_ + (offset + rate * dt) * decay;
  velocity_ = (velocity_ - grip_pulsation * rate * dt) * decay;
  return {position_, velocity_};
}

LiveLoop::LiveLoop(const Scene& scene, Subject& subject, const LiveOptions& options)
    : snapshots(Snapshot{.position = subject.node_positions()}),
      options_(options),
      drive_(scene.drive.value_or(Drive{})),
      coupling_(scene.falcon.value_or(FalconDrive{})),
      has_tool_(scene.needle || scene.probe),
      step_(scene.simulation.step),
      publish_every_(
          std::max(1L, static_cast<long>(std::floor(1.0 / (frames_per_second * step_))))),
      record_(step_),
      model_(dynamic_cast<ModelSubject*>(&subject)) {
  stiffness_.fill(1.0);
  wanted.set(stiffness_);
  grip_.set_speed(drive_.speed);
  for (const Column& column : subject.columns()) { names_.push_back(column.name); }
  const auto place_of = [this](std::string_view name) {
    const auto found = std::ranges::find(names_, name);
    return found == names_.end() ? -1 : static_cast<int>(found - names_.begin()) + 1;
  };
  column_ = {place_of("tool.depth_m"),    place_of("tool.force_n"),
             place_of("tool.applied_n"),  place_of("syringe.pressure_pa"),
             place_of("tool.cutting_n"),  place_of("tool.friction_n"),
             place_of("tool.stiffness_n")};
  row_.resize(1 + names_.size() + (has_tool_ ? 2 : 0));
  state_.running = 1.0;
}

std::vector<std::string> LiveLoop::row_names() const {
  std::vector<std::string> names{"time_s"};
  names.insert(names.end(), names_.begin(), names_.end());
  if (has_tool_) { names.insert(names.end(), {"grip.position_m", "grip.velocity_m_per_s"}); }
  return names;
}

void LiveLoop::begin(Subject& subject, device::DeadlineClock* clock) {
  clock_ = clock;
  second_began_ = -1.0;
  slow_seconds_ = 0;
  if (reset_) { state_.run += 1.0; }
  reset_ = false;
  state_.ended = state_.ticks = 0.0;
  present_ = stiffness_;
  state_.changed = -1.0;
  device_held_ = false;
  if (has_tool_) {
    grip_.place_at(subject.tool_motion().place);
    if (options_.drives && drive_.depth) { grip_.drive_to(*drive_.depth); }
    held_ = {grip_.position(), 0.0};
  }
  for (const ToolHappening& each : subject.tool_happenings()) {  // the loop clears them with row 0
    (void)events.push({each, static_cast<int>(state_.run)});
  }
  write_row(subject);
  publish(subject);
}

void LiveLoop::wait_for_reset(Subject& subject, bool diverged, const std::atomic<bool>& stop) {
  state_.ended = diverged ? 2.0 : 1.0;
  force_.push = 0.0;
  while (!reset_ && !stop) {
    Command command;
    while (commands.pop(command)) { obey(command); }
    publish(subject);
    std::this_thread::sleep_for(between_looks);
  }
}

void LiveLoop::obey(const Command& command) noexcept {
  if (!std::isfinite(command.value)) { return; }
  switch (command.kind) {
    case Command::Kind::start:
      state_.running = 1.0;
      state_.too_slow = 0.0;
      force_.stopped = false;
      break;
    case Command::Kind::pause: state_.running = 0.0; break;
    case Command::Kind::reset: reset_ = true; break;
    case Command::Kind::drive: grip_.drive_to(command.value); break;
    case Command::Kind::hold: grip_.point_to(command.value); break;
    case Command::Kind::speed:
      grip_.set_speed(std::clamp(command.value, 0.0, fastest_drive));
      break;
    case Command::Kind::stiffness:
      if (command.index < stiffness_.size()) {
        stiffness_[command.index] = std::clamp(command.value, least_factor, most_factor);
        wanted.set(stiffness_);
        compare_materials();
      }
      break;
    case Command::Kind::stop:
      state_.running = 0.0;
      force_.stopped = true;
      break;
  }
}

TickOrder LiveLoop::before_tick(Subject& subject) noexcept {
  Command command;
  for (int n = 0; n < most_commands_per_tick && commands.pop(command); ++n) { obey(command); }
  if (reset_) { return {.what = TickOrder::What::end}; }
  if (state_.running == 0.0) { return {.what = TickOrder::What::hold}; }
  take_materials(subject);
  return {.what = TickOrder::What::step, .input = input(subject)};
}

void LiveLoop::compare_materials() noexcept {
  const bool at_reset = model_ == nullptr || needs_reset;
  state_.changing = stiffness_ == present_ ? 0.0 : at_reset ? 2.0 : 1.0;
}

void LiveLoop::take_materials(const Subject& subject) noexcept {
  if (offered.load(std::memory_order_relaxed) == nullptr) { return; }
  NextSimulation* const next = offered.exchange(nullptr, std::memory_order_acquire);
  model_->exchange(next->simulation);
  next->tick = subject.ticks();
  present_ = next->factors;
  compare_materials();
  state_.changed = subject.time();
  returned.store(next, std::memory_order_release);
}

std::optional<ToolInput> LiveLoop::input(Subject& subject) noexcept {
  if (!has_tool_) { return {}; }
  if (options_.device == nullptr) { return held_ = grip_.advance(step_); }
  const device::falcon::GripReading& reading = options_.device->reading();
  state_.device = static_cast<double>(reading.state);
  if (!reading.valid()) {
    device_held_ = false;
    force_.push = 0.0;
    held_.velocity = 0.0;  // the hand's end of the coupling rests
    return held_;
  }
  if (!device_held_) { device_start_ = held_.position - reading.place; }  // no jump of the tool
  device_held_ = true;
  held_ = {device_start_ + reading.place, reading.velocity};
  const ToolMotion tool = subject.tool_motion();
  force_.push = coupling_.coupling_stiffness * (held_.position - tool.place) +
                coupling_.coupling_viscosity * (held_.velocity - tool.velocity);
  return held_;
}

void LiveLoop::after_tick(Subject& subject, const certificate::TickTimes& times,
                          bool stepped) noexcept {
  if (options_.device != nullptr) {
    if (!stepped) { force_.push = 0.0; }
    ++force_.count;
    options_.device->order(force_);
    if (!stepped) { state_.device = static_cast<double>(options_.device->reading().state); }
    state_.device_force = force_.push;
  }
  if (stepped) {
    for (const ToolHappening& each : subject.tool_happenings()) {
      (void)events.push({each, static_cast<int>(state_.run)});
    }
    subject.forget_tool_happenings();
    write_row(subject);
    state_.ticks += 1.0;
  }
  record_.add(times, {.scene_time = subject.time()});
  state_.periods += 1.0;
  state_.missed = static_cast<double>(record_.misses.count());
  state_.worst = record_.worst_response.seconds;
  measure_pace(times);
  if (static_cast<long>(state_.periods) % publish_every_ == 0) { publish(subject); }
}

/// A scene that cannot keep its period runs slower than the clock. With a device it is paused
/// instead, because a force in slow motion is another one.
void LiveLoop::measure_pace(const certificate::TickTimes& times) noexcept {
  if (const double late = times.end - times.due; late > most_late && clock_ != nullptr) {
    clock_->put_off(late);
    state_.left_out += late;
  }
  if (second_began_ < 0.0) { second_began_ = times.begin; }
  second_periods_ += 1.0;
  const double elapsed = times.end - second_began_;
  if (elapsed < 1.0) { return; }
  state_.pace = std::min(1.0, second_periods_ * step_ / elapsed);
  second_began_ = times.end;
  second_periods_ = 0.0;
  slow_seconds_ = state_.pace < least_pace ? slow_seconds_ + 1 : 0;
  if (slow_seconds_ >= 2 && options_.device != nullptr && state_.running != 0.0) {
    obey({.kind = Command::Kind::stop});
    state_.too_slow = 1.0;
    slow_seconds_ = 0;
  }
}

void LiveLoop::write_row(Subject& subject) noexcept {
  row_[0] = subject.time();
  subject.sample(std::span(row_).subspan(1, names_.size()));
  if (has_tool_) {
    row_[row_.size() - 2] = held_.position;
    row_[row_.size() - 1] = held_.velocity;
    state_.place = subject.tool_motion().place;
  }
  state_.time = row_[0];
  state_.depth = value_in(row_, column_[0]);
  state_.reaction = value_in(row_, column_[1]);
  state_.applied = value_in(row_, column_[2]);
  state_.pressure = value_in(row_, column_[3]);
  state_.cutting = value_in(row_, column_[4]);
  state_.friction = value_in(row_, column_[5]);
  state_.pressing = value_in(row_, column_[6]);
  if (!options_.records) { return; }
  if (rows.write_available() < row_.size()) {
    state_.lost_rows += 1.0;
    return;
  }
  rows.push(row_.data(), row_.size());
}

void LiveLoop::publish(Subject& subject) noexcept {
  state_.grip = held_.position;
  state_.target = grip_.target();
  state_.speed = grip_.speed();
  compare_materials();
  Snapshot& snapshot = snapshots.back();
  snapshot.state = state_;
  subject.node_positions(snapshot.position);
  snapshot.seal();
  snapshots.publish();
}

RowWriter::RowWriter(LiveLoop& loop, const std::filesystem::path& file)
    : loop_(loop), out_(file, std::ios::binary | std::ios::trunc), row_(loop.row_names().size()) {
  for (const std::string& name : loop.row_names()) { text_ += (text_.empty() ? "" : ",") + name; }
  text_ += '\n';
  thread_ = std::thread([this] {
    pthread_setname_np(pthread_self(), "rows");  // instead of the name of the thread that starts it
    while (!stop_) {
      write_waiting();
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    write_waiting();
  });
}

RowWriter::~RowWriter() { (void)finish(); }

bool RowWriter::finish() {
  stop_ = true;
  if (thread_.joinable()) { thread_.join(); }
  return out_.good();
}

/// Writes in pieces of whole rows, each with one call of the system.
void RowWriter::write_waiting() {
  constexpr std::size_t piece = std::size_t{1} << 16U;
  while (true) {
    while (text_.size() < piece && loop_.rows.read_available() >= row_.size()) {
      loop_.rows.pop(row_.data(), row_.size());
      for (std::size_t n = 0; n < row_.size(); ++n) {
        if (n > 0) { text_ += ','; }
        io::append_number(text_, row_[n]);
      }
      text_ += '\n';
      ++rows_;
    }
    if (text_.empty()) { return; }
    out_.write(text_.data(), static_cast<std::streamsize>(text_.size()));
    out_.flush();
    text_.clear();
  }
}

Scene with_stiffness(Scene scene, const std::vector<std::string>& names,
                     const StiffnessFactors& factors) {
  for (std::size_t n = 0; n < names.size(); ++n) {
    std::ranges::find(scene.materials, names[n], &Material::name)->youngs_modulus *= factors[n];
  }
  return scene;
}

MaterialBuilder::MaterialBuilder(LiveLoop& loop, const ModelSubject& subject, Scene scene,
                                 std::vector<std::string> names, const StiffnessFactors& now)
    : loop_(loop),
      subject_(subject),
      scene_(std::move(scene)),
      names_(std::move(names)),
      now_(now) {
  loop_.needs_reset = false;
  thread_ = std::thread([this] {
    pthread_setname_np(pthread_self(), "materials");
    while (!stop_) {
      if (refusal_.empty() && loop_.wanted.get() != now_) { build(); }
      std::this_thread::sleep_for(between_looks);
    }
  });
}

MaterialBuilder::~MaterialBuilder() { (void)finish(); }

const std::vector<MaterialChange>& MaterialBuilder::finish() {
  stop_ = true;
  if (thread_.joinable()) { thread_.join(); }
  return changes_;
}

/// Builds a simulation for the wanted factors and offers it until the loop takes it, the factors
/// change again, or the run ends.
void MaterialBuilder::build() {
  const StiffnessFactors factors = loop_.wanted.front();
  std::unique_ptr<NextSimulation> next;
  try {
    next = make(factors);
  } catch (const std::exception& problem) {
    refusal_ = problem.what();
    loop_.needs_reset = true;
    return;
  }
  loop_.offered.store(next.get(), std::memory_order_release);
  while (loop_.returned.exchange(nullptr, std::memory_order_acquire) == nullptr) {
    const bool outdated = stop_ || loop_.wanted.get() != factors;
    if (outdated && loop_.offered.exchange(nullptr) != nullptr) { return; }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  note(*next);
}

std::unique_ptr<NextSimulation> MaterialBuilder::make(const StiffnessFactors& factors) const {
  const Scene changed = with_stiffness(scene_, names_, factors);
  auto next = std::make_unique<NextSimulation>(
      NextSimulation{Simulation(changed, build_network(changed)), factors});
  next->simulation.prepare_to_continue(subject_.simulation());
  return next;
}

void MaterialBuilder::note(const NextSimulation& taken) {
  for (std::size_t n = 0; n < names_.size(); ++n) {
    if (taken.factors[n] == now_[n]) { continue; }
    const auto given = std::ranges::find(scene_.materials, names_[n], &Material::name);
    changes_.push_back({taken.tick, n, taken.factors[n] * given->youngs_modulus});
  }
  now_ = taken.factors;
}

}  // namespace palpate::live
