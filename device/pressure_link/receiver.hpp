// SPDX-License-Identifier: MIT
#pragma once
/// Host end of the pressure link. A separate thread reads the line, so that a 1 kHz tick reads only
/// data that has already arrived.

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <span>
#include <thread>

#include "device/byte_link.hpp"
#include "device/latest_value.hpp"
#include "device/pressure_link/frame.hpp"

namespace palpate::device::pressure_link {

struct PressureSample {
  std::int64_t index = -1;  ///< frame periods since the first frame; -1: no frame yet
  /// Time of the link at which the last byte of the frame arrived [s], computed from the time of
  /// the read and the number of later bytes.
  double arrival = 0.0;
  std::int16_t pressure = 0;  ///< gauge [0.1 mmHg]
  bool over_range = false;
  bool battery_low = false;
};

class Receiver {
 public:
  /// Capacity of the sample queue: 34 s of line.
  static constexpr std::size_t queue_capacity = 4096;

  /// Reads `link` until it ends or the receiver is destroyed.
  explicit Receiver(ByteLink& link);
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;
  ~Receiver();

  /// Functions for one consumer thread. They do not wait, allocate or make a system call.
  const PressureSample& latest() noexcept { return latest_.get(); }
  std::optional<PressureSample> next() noexcept {
    PressureSample sample;
    return queue_.pop(sample) ? std::optional(sample) : std::nullopt;
  }
  /// Number of samples that did not fit in the queue; latest() still returned them.
  [[nodiscard]] std::int64_t overflowed() const noexcept { return overflowed_.load(); }
  /// True if the link has ended and all its samples are in the queue.
  [[nodiscard]] bool ended() const noexcept { return ended_.load(); }

  /// Ends the thread. The counts no longer change.
  void stop();
  [[nodiscard]] const ReaderCounts& counts() const noexcept { return reader_.counts(); }

 private:
  void run() noexcept;
  std::span<const std::uint8_t> waiting_bytes() noexcept;
  void take(std::span<const std::uint8_t> bytes) noexcept;
  void hand_over(const ReceivedFrame& received, double arrival) noexcept;

  static constexpr std::size_t most_at_once = 65536;  ///< capacity of a pipe; a terminal holds less
  ByteLink& link_;
  std::array<std::uint8_t, most_at_once> bytes_{};
  FrameReader reader_{};
  PressureSample sample_{};  ///< used by the reading thread only
  Queue<PressureSample, queue_capacity> queue_{};
  LatestValue<PressureSample> latest_{};
  std::atomic<std::int64_t> overflowed_{0};
  std::atomic<bool> ended_{false};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace palpate::device::pressure_link
