// SPDX-License-Identifier: MIT
#pragma once
/// The host's end of the pressure link: a thread of its own reads the line, so that a 1 kHz tick
/// only looks at what is there.

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <span>
#include <thread>

#include "device/bounded_queue.hpp"
#include "device/byte_link.hpp"
#include "device/pressure_link/frame.hpp"

namespace palpate::device::pressure_link {

struct PressureSample {
  std::int64_t index = -1;  ///< frame periods since the first frame; -1: none has come yet
  /// Clock of the link when its last byte came, told back from when it was read by the bytes behind
  /// it [s].
  double arrival = 0.0;
  std::int16_t pressure = 0;  ///< gauge [0.1 mmHg]
  bool over_range = false;
  bool battery_low = false;
};

class Receiver {
 public:
  /// Samples that wait for the consumer at most: 34 s of line.
  static constexpr std::size_t queue_capacity = 4096;

  /// Reads `link` until it ends or the receiver is destroyed.
  explicit Receiver(ByteLink& link);
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;
  ~Receiver();

  /// For one consumer's thread; these neither wait nor allocate nor call the operating system.
  const PressureSample& latest() noexcept { return latest_.get(); }
  std::optional<PressureSample> next() noexcept { return queue_.pop(); }
  /// Samples that the queue had no room for; latest() did see them.
  [[nodiscard]] std::int64_t overflowed() const noexcept { return overflowed_.load(); }
  /// The link has ended and every sample of it was handed over.
  [[nodiscard]] bool ended() const noexcept { return ended_.load(); }

  /// Ends the thread, after which the counts are final.
  void stop();
  [[nodiscard]] const ReaderCounts& counts() const noexcept { return reader_.counts(); }

 private:
  void run() noexcept;
  std::span<const std::uint8_t> waiting_bytes() noexcept;
  void take(std::span<const std::uint8_t> bytes) noexcept;
  void hand_over(const ReceivedFrame& received, double arrival) noexcept;

  static constexpr std::size_t most_at_once = 65536;  ///< what a pipe holds; a terminal holds less
  ByteLink& link_;
  std::array<std::uint8_t, most_at_once> bytes_{};
  FrameReader reader_{};
  PressureSample sample_{};  ///< the reading thread's
  HandoverQueue<PressureSample, queue_capacity> queue_{};
  LatestValue<PressureSample> latest_{};
  std::atomic<std::int64_t> overflowed_{0};
  std::atomic<bool> ended_{false};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace palpate::device::pressure_link
