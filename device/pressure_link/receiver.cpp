// SPDX-License-Identifier: MIT
#include "device/pressure_link/receiver.hpp"

#include <array>

namespace palpate::device::pressure_link {
namespace {

constexpr double longest_wait = 0.05;  // [s], after which a request to stop is seen
constexpr std::size_t most_at_once = 512;

}  // namespace

Receiver::Receiver(ByteLink& link) : link_(link), thread_([this] { run(); }) {}

Receiver::~Receiver() { stop(); }

void Receiver::stop() {
  stop_ = true;
  if (thread_.joinable()) { thread_.join(); }
}

void Receiver::hand_over(const ReceivedFrame& received) noexcept {
  const double now = link_.now();
  const bool first = sample_.index < 0;
  sample_ = {.index = first ? 0 : sample_.index + frames_since(received, now - sample_.arrival),
             .arrival = now,
             .pressure = received.frame.pressure,
             .over_range = received.frame.over_range,
             .battery_low = received.frame.battery_low};
  latest_.set(sample_);
  if (!queue_.push(sample_)) { overflowed_.fetch_add(1, std::memory_order_relaxed); }
}

void Receiver::run() noexcept {
  std::array<std::uint8_t, most_at_once> buffer;
  while (!stop_ && !link_.ended()) {
    (void)link_.wait_until(link_.now() + longest_wait);
    for (std::size_t count = link_.read(buffer); count > 0 && !stop_; count = link_.read(buffer)) {
      for (std::size_t n = 0; n < count; ++n) {
        if (const auto received = reader_.take(buffer[n])) { hand_over(*received); }
      }
    }
  }
  if (link_.ended()) { reader_.finish(); }
  ended_ = link_.ended();
}

}  // namespace palpate::device::pressure_link
