// SPDX-License-Identifier: MIT

#include "device/pressure_link/transducer.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace palpate::device::pressure_link {

Transducer::Transducer(std::vector<std::optional<Frame>> frames, const TransducerOptions& options)
    : frames_(std::move(frames)),
      options_(options),
      line_(options.faults, falcon::LinkFault::Direction::to_host) {
  for (std::optional<Frame>& frame : frames_) {
    if (frame && options_.battery_low) { frame->battery_low = true; }
  }
}

std::int64_t Transducer::byte_count() const noexcept {
  if (frames_.empty()) { return 0; }
  return options_.repeats ? std::numeric_limits<std::int64_t>::max()
                          : static_cast<std::int64_t>(frames_.size() * frame_bytes);
}

double Transducer::due(std::int64_t byte) const noexcept {
  return *begin_ + static_cast<double>(byte + 1) / bytes_per_second;
}

void Transducer::send_byte(double now_s) noexcept {
  const auto number = static_cast<std::size_t>(bytes_passed_);
  const std::optional<Frame>& frame = frames_[number / frame_bytes % frames_.size()];
  const std::size_t place = number % frame_bytes;
  ++bytes_passed_;
  if (!frame) { return; }
  if (place == 0) {
    Frame numbered = *frame;
    numbered.sequence = static_cast<std::uint8_t>(number / frame_bytes);
    under_way_ = encode(numbered);
  }
  line_.send({&under_way_[place], 1}, now_s);
  if (place + 1 == frame_bytes) { ++frames_sent_; }
}

void Transducer::deliver(ByteLink& link, double now_s) noexcept {
  std::array<std::uint8_t, 512> buffer;
  for (std::size_t count = 0; (count = line_.receive(buffer, now_s)) > 0;) {
    if (!link.write({buffer.data(), count})) { ++lost_writes_; }
  }
}

void Transducer::serve(ByteLink& link) noexcept {
  const double now = link.now();
  if (!begin_) { begin_ = now; }
  constexpr int most_between_deliveries = 1024;  // well below what the channel can hold
  int sent = 0;
  while (bytes_passed_ < byte_count() && due(bytes_passed_) <= now) {
    send_byte(due(bytes_passed_));
    if (++sent % most_between_deliveries == 0) { deliver(link, now); }
  }
  deliver(link, now);
}

double Transducer::next_call() const noexcept {
  if (!begin_) { return 0.0; }
  const double delivery = line_.next_arrival().value_or(std::numeric_limits<double>::infinity());
  return bytes_passed_ < byte_count() ? std::min(due(bytes_passed_), delivery) : delivery;
}

bool Transducer::finished() const noexcept {
  return bytes_passed_ >= byte_count() && !line_.next_arrival();
}

}  // namespace palpate::device::pressure_link
