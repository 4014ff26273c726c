// SPDX-License-Identifier: MIT
#pragma once
/// Device end of the pressure link, which sends frames byte by byte at the rate of a 9600 baud
/// line.

#include <cstdint>
#include <optional>
#include <vector>

#include "device/byte_link.hpp"
#include "device/falcon/link_faults.hpp"
#include "device/pressure_link/frame.hpp"

namespace palpate::device::pressure_link {

struct TransducerOptions {
  /// Faults of the line (drop, duplicate, corrupt, latency, unplug), as for the Falcon.
  falcon::FaultScript faults{};
  bool battery_low = false;  ///< status bit set in every frame
  bool repeats = false;      ///< restarts after the last sample without a pause
};

/// Sender of frames. The time of each byte depends only on the clock of the link, not on the
/// frequency of serve() calls.
class Transducer {
 public:
  /// `frames` has one element per frame period; an empty one means eight byte times of silence.
  /// Sequence numbers also count the empty elements.
  explicit Transducer(std::vector<std::optional<Frame>> frames,
                      const TransducerOptions& options = {});

  /// Sends all bytes due since the first call. Does not allocate.
  void serve(ByteLink& link) noexcept;
  /// Returns the time at which the next byte is sent [s]: the present before the first call,
  /// infinity after the last byte.
  [[nodiscard]] double next_call() const noexcept;
  /// Returns true if everything was sent and delivered.
  [[nodiscard]] bool finished() const noexcept;

  [[nodiscard]] std::int64_t frames_sent() const noexcept { return frames_sent_; }
  [[nodiscard]] const falcon::FaultCounts& faults() const noexcept { return line_.counts(); }
  /// Number of writes that the link did not accept.
  [[nodiscard]] std::int64_t lost_writes() const noexcept { return lost_writes_; }

 private:
  [[nodiscard]] std::int64_t byte_count() const noexcept;  ///< byte times that the frames occupy
  [[nodiscard]] double due(std::int64_t byte) const noexcept;
  void send_byte(double now_s) noexcept;
  void deliver(ByteLink& link, double now_s) noexcept;

  std::vector<std::optional<Frame>> frames_;
  TransducerOptions options_;
  falcon::FaultChannel line_;
  FrameBytes under_way_{};
  std::optional<double> begin_{};  ///< clock of the link at the first call [s]
  std::int64_t bytes_passed_ = 0;  ///< byte times sent, including silence
  std::int64_t frames_sent_ = 0;
  std::int64_t lost_writes_ = 0;
};

}  // namespace palpate::device::pressure_link
