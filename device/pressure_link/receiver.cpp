// SPDX-License-Identifier: MIT

#include "device/pressure_link/receiver.hpp"

namespace palpate::device::pressure_link {
namespace {

constexpr double longest_wait = 0.05;  // longest delay of a stop request [s]

}  // namespace

Receiver::Receiver(ByteLink& link) : link_(link), thread_([this] { run(); }) {}

Receiver::~Receiver() { stop(); }

void Receiver::stop() {
  stop_ = true;
  if (thread_.joinable()) { thread_.join(); }
}

void Receiver::hand_over(const ReceivedFrame& received, double arrival) noexcept {
  const bool first = sample_.index < 0;
  sample_ = {.index = first ? 0 : sample_.index + frames_since(received, arrival - sample_.arrival),
             .arrival = arrival,
             .pressure = received.frame.pressure,
             .over_range = received.frame.over_range,
             .battery_low = received.frame.battery_low};
  latest_.set(sample_);
  if (!queue_.push(sample_)) { overflowed_.fetch_add(1, std::memory_order_relaxed); }
}

std::span<const std::uint8_t> Receiver::waiting_bytes() noexcept {
  std::size_t filled = 0;
  while (filled < bytes_.size() && !stop_) {
    const std::size_t count = link_.read(std::span(bytes_).subspan(filled));
    if (count == 0) { break; }
    filled += count;
  }
  return std::span(bytes_).first(filled);
}

/// Processes bytes and computes their arrival times from the rate of the line. If this thread was
/// preempted, bytes have accumulated, and the time of the read would show a gap that does not
/// exist.
void Receiver::take(std::span<const std::uint8_t> bytes) noexcept {
  const double now = link_.now();
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    const auto behind = static_cast<double>(bytes.size() - n - 1);
    const auto received = reader_.take(bytes[n]);
    if (received) { hand_over(*received, now - behind / bytes_per_second); }
  }
}

void Receiver::run() noexcept {
  while (!stop_ && !link_.ended()) {
    (void)link_.wait_until(link_.now() + longest_wait);
    take(waiting_bytes());
  }
  if (link_.ended()) { reader_.finish(); }
  ended_ = link_.ended();
}

}  // namespace palpate::device::pressure_link
