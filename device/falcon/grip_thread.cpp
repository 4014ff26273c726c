// SPDX-License-Identifier: MIT

#include "device/falcon/grip_thread.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "device/real_time.hpp"

namespace palpate::device::falcon {

namespace {

constexpr double velocity_cutoff = 100.0;  // [Hz] of the low pass on differences of counts
constexpr double between_openings = 0.2;   // [s]
constexpr double reply_patience = 4e-3;    // [s]
constexpr double most_jump = 5e-3;         // [m] between two replies; no hand moves at 5 m/s
constexpr int most_jumps = 5;              // in a row; then the grip is there
constexpr int farewells = 5;               // requests without torque at the end

}  // namespace

GripThread::GripThread(ByteLink& link, const GripThreadOptions& options)
    : link_(link),
      options_(options),
      driver_(link, {.reply_deadline = reply_patience, .keep_late = true}) {
  reading_.set({.state = GripState::opening});
  thread_ = std::thread([this] { run(); });
}

GripThread::~GripThread() { stop(); }

void GripThread::stop() {
  stop_ = true;
  if (thread_.joinable()) { thread_.join(); }
}

void GripThread::run() noexcept {
  Clock& clock = monotonic_clock();
  if (open()) {
    answered_ = ordered_ = clock.now();
    for (double due = clock.now(); !stop_ && !link_.ended();) {
      exchange(clock.now());
      due = std::max(due + options_.period, clock.now() - options_.period);  // no bursts
      clock.sleep_until(due);
    }
  }
  for (int n = 0; n < farewells && !link_.ended(); ++n) { (void)driver_.exchange({}); }
  tell(link_.ended() ? GripState::ended : GripState::opening);
}

/// Returns false if the thread must end first.
bool GripThread::open() noexcept {
  while (!stop_ && !link_.ended()) {
    const OpenResult result = driver_.open(options_.firmware);
    if (result == OpenResult::loaded || result == OpenResult::was_running) {
      tell(GripState::homing);
      return true;
    }
    monotonic_clock().sleep_until(monotonic_now() + between_openings);
  }
  return false;
}

void GripThread::exchange(double time) noexcept {
  const double push = force(time);
  HostPacket request{.homing = true, .leds = {.green = state_ == GripState::ready}};
  if (push != 0.0) { request.words = profile_.words(position_, {0.0, 0.0, push}).sent; }
  const std::optional<DevicePacket> reply = driver_.exchange(request);
  ++counts_.exchanges;
  if (reply) {
    answered_ = time;
    read(*reply);
  } else {
    ++counts_.lost;
    if (time - answered_ > options_.watchdog) {
      placed_ = false;
      let_go();
      tell(GripState::silent);
    }
  }
}

/// Force of this exchange [N]: the newest order, limited, during the ramp a part of it, and zero
/// wherever something is not as it must be.
double GripThread::force(double time) noexcept {
  const ForceOrder& order = order_.get();
  if (order.count != order_count_) { ordered_ = time; }
  order_count_ = order.count;
  if (order.stopped || time - ordered_ > options_.watchdog ||
      !(state_ == GripState::ramp || state_ == GripState::ready)) {
    let_go();
    return 0.0;
  }
  off_ = false;
  scale_ = std::min(1.0, scale_ + options_.period / options_.ramp);
  if (std::isnan(order.push)) { return 0.0; }
  if (std::abs(order.push) > options_.most_force) { ++counts_.limited; }
  return scale_ * std::clamp(order.push, -options_.most_force, options_.most_force);
}

void GripThread::let_go() noexcept {
  if (!off_) { ++counts_.watchdog; }
  off_ = true;
  scale_ = 0.0;
}

void GripThread::read(const DevicePacket& reply) noexcept {
  if (!std::ranges::all_of(reply.homed, [](bool leg) { return leg; })) {
    placed_ = false;
    let_go();
    return tell(GripState::homing);
  }
  const Eigen::Vector3d position = profile_.position(reply.counts);
  const bool jumps = placed_ && (position - position_).norm() > most_jump;
  if (jumps && ++jumps_ < most_jumps) {  // a packet has no checksum: a changed count
    ++counts_.implausible;
    return;
  }
  jumps_ = 0;
  const double share = 1.0 - std::exp(-2.0 * std::numbers::pi * velocity_cutoff * options_.period);
  const double rate = (position.z() - position_.z()) / options_.period;
  velocity_ = placed_ && !jumps ? velocity_ + share * (rate - velocity_) : 0.0;
  position_ = position;
  placed_ = true;
  tell(order_.front().stopped ? GripState::stopped
       : scale_ < 1.0         ? GripState::ramp
                              : GripState::ready);
}

void GripThread::tell(GripState state) noexcept {
  state_ = state;
  reading_.set({.place = -position_.z(), .velocity = -velocity_, .state = state});
}

}  // namespace palpate::device::falcon
