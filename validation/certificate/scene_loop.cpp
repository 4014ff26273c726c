// SPDX-License-Identifier: MIT

#include "validation/certificate/scene_loop.hpp"

#include <algorithm>
#include <cmath>

#include "model/problem/needle_path.hpp"
#include "model/tissue/network_builder.hpp"
#include "validation/comparison/link_recording.hpp"
#include "validation/number_text.hpp"

namespace palpate::certificate {

namespace {

using device::falcon::FaultScript;
using device::falcon::LinkFault;

bool in_hand(const Scene& scene) { return scene.drive && scene.drive->kind == Drive::Kind::falcon; }

double periods_of_step(const Scene& scene, double rate) { return scene.simulation.step * rate; }

bool is_whole(double number) {
  return number >= 0.5 && std::abs(number - std::round(number)) <= 1e-6 * number;
}

/// Faults of all kinds at a low rate, and one loss of power.
FaultScript wire_faults(const Scene& scene) {
  const double middle = 0.5 * scene.simulation.duration;
  return {.seed = 1,
          .faults = {{.kind = LinkFault::Kind::drop, .probability = 0.01},
                     {.kind = LinkFault::Kind::duplicate, .probability = 0.01},
                     {.kind = LinkFault::Kind::corrupt, .probability = 0.01},
                     {.kind = LinkFault::Kind::power_loss, .start = middle, .end = middle + 5e-3}}};
}

std::unique_ptr<Subject> subject_of(const Scene& scene, const SceneLoopOptions& options) {
  if (!options.subject) {
    return std::make_unique<ModelSubject>(
        options.network != nullptr ? Simulation(scene, *options.network) : Simulation(scene));
  }
  std::unique_ptr<Subject> subject = options.subject();
  subject->load(scene, options.network != nullptr ? *options.network : build_network(scene), true);
  return subject;
}

std::size_t pressure_column(const std::vector<Column>& columns) {
  const auto column = std::ranges::find(columns, "syringe.pressure_pa", &Column::name);
  return static_cast<std::size_t>(column - columns.begin());
}

}  // namespace

double rate_of(const Scene& scene) {
  return in_hand(scene) ? scene.falcon.value_or(FalconDrive{}).rate : 1.0 / scene.simulation.step;
}

std::string why_not_at(const Scene& scene, double rate) {
  const double own = scene.falcon.value_or(FalconDrive{}).rate;
  if (in_hand(scene) && !(std::abs(rate - own) <= 1e-9 * own)) {
    return "the rate " + plain_number(rate) +
           " Hz is not that of the scene's haptic loop; falcon.rate, " + plain_number(own) + " Hz";
  }
  if (is_whole(periods_of_step(scene, rate))) { return {}; }
  return "the step " + plain_number(scene.simulation.step, 6) +
         " s is no whole number of periods of " + plain_number(1.0 / rate, 6) + " s; a rate of " +
         plain_number(1.0 / scene.simulation.step, 6) + " Hz or a whole multiple of it";
}

SceneLoop::SceneLoop(const Scene& scene, double rate, const SceneLoopOptions& options)
    : subject_(subject_of(scene, options)),
      periods_of_step_(std::lround(periods_of_step(scene, rate))),
      step_(scene.simulation.step),
      replay_(scene),
      has_pressure_(scene.syringe && scene.needle),
      damages_frames_(options.faults) {
  if (in_hand(scene)) {
    falcon_.emplace(
        scene, *subject_,
        FalconLoopOptions{.faults = options.faults ? wire_faults(scene) : FaultScript{}});
  }
  constexpr std::size_t enough = 64;  // twice what the model keeps
  happened_.reserve(enough);
  take_happenings();
  if (has_pressure_) {
    row_.resize(subject_->columns().size());
    pressure_column_ = pressure_column(subject_->columns());
  }
}

StepStatus SceneLoop::tick() noexcept {
  if (begun_) { happened_.clear(); }
  begun_ = true;
  const long before = subject_->ticks();
  StepStatus status = StepStatus::ok;
  if (falcon_) {
    status = falcon_->device_tick();
  } else if (period_ == 0) {
    status = subject_->step(replay_.at(subject_->time() + step_));
  }
  period_ = period_ + 1 < periods_of_step_ ? period_ + 1 : 0;
  if (has_pressure_ && subject_->ticks() > before) { send_pressure(); }
  take_happenings();
  return status;
}

/// Reads and clears the events as a trace does; neither list grows.
void SceneLoop::take_happenings() noexcept {
  for (const ToolHappening& each : subject_->tool_happenings()) {
    if (happened_.size() < happened_.capacity()) { happened_.push_back(each); }
  }
  subject_->forget_tool_happenings();
}

/// Encodes, sends and decodes the frames that are due.
void SceneLoop::send_pressure() noexcept {
  namespace link = device::pressure_link;
  subject_->sample(row_);
  while (static_cast<double>(frames_) / link::frames_per_second <= subject_->time()) {
    if (const auto frame = frame_of(row_[pressure_column_], static_cast<std::size_t>(frames_))) {
      link::FrameBytes bytes = link::encode(*frame);
      if (damages_frames_ && frames_ % 2 == 1) { bytes[4] ^= 0xFFU; }
      for (const std::uint8_t byte : bytes) { (void)reader_.take(byte); }
    }
    ++frames_;
  }
}

bool SceneLoop::over() const noexcept {
  return period_ == 0 && subject_->ticks() >= subject_->tick_count();
}

long SceneLoop::tick_count() const noexcept { return subject_->tick_count() * periods_of_step_; }

Moment SceneLoop::moment() const noexcept {
  Moment moment{.scene_time = subject_->time()};
  if (!happenings().empty()) { moment.happening = happenings().back(); }
  return moment;
}

HappeningNames::HappeningNames(const Scene& scene) {
  if (!scene.needle && !scene.probe) { return; }
  const NeedlePath path(scene, build_network(scene));
  for (const PathInterval& interval : path.intervals()) { labels_.push_back(interval.label); }
}

std::string HappeningNames::of(const ToolHappening& happening) const {
  const std::string name(name_of(happening.event));
  return happening.interval < labels_.size() ? name + ": " + labels_[happening.interval] : name;
}

}  // namespace palpate::certificate
