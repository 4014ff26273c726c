// SPDX-License-Identifier: MIT
#pragma once
/// The device's end of the pressure link: frames byte by byte at the pace of a 9600 baud line.

#include <cstdint>
#include <optional>
#include <vector>

#include "device/byte_link.hpp"
#include "device/falcon/link_faults.hpp"
#include "device/pressure_link/frame.hpp"

namespace palpate::device::pressure_link {

struct TransducerOptions {
  /// Those of the line (drop, duplicate, corrupt, latency, unplug), as on the Falcon's wire.
  falcon::FaultScript faults{};
  bool battery_low = false;  ///< said in every frame
  bool repeats = false;      ///< begins again after the last sample, without a pause
};

/// Which byte is sent when depends on the link's clock alone, not on how often serve() is called.
class Transducer {
 public:
  /// One place per frame period; nothing where no frame is sent while the line stays silent for
  /// its eight bytes. Sequence numbers count places, also those without a frame.
  explicit Transducer(std::vector<std::optional<Frame>> frames,
                      const TransducerOptions& options = {});

  /// Sends what the line has had time for since the first call. Allocates nothing.
  void serve(ByteLink& link) noexcept;
  /// When the next byte is through the line [s]: at once before the first call, never (infinity)
  /// after the last byte.
  [[nodiscard]] double next_call() const noexcept;
  /// Everything was sent and delivered.
  [[nodiscard]] bool finished() const noexcept;

  [[nodiscard]] std::int64_t frames_sent() const noexcept { return frames_sent_; }
  [[nodiscard]] const falcon::FaultCounts& faults() const noexcept { return line_.counts(); }
  /// Writes that the link did not take.
  [[nodiscard]] std::int64_t lost_writes() const noexcept { return lost_writes_; }

 private:
  [[nodiscard]] std::int64_t byte_count() const noexcept;  ///< that the line is occupied for
  [[nodiscard]] double due(std::int64_t byte) const noexcept;
  void send_byte(double now_s) noexcept;
  void deliver(ByteLink& link, double now_s) noexcept;

  std::vector<std::optional<Frame>> frames_;
  TransducerOptions options_;
  falcon::FaultChannel line_;
  FrameBytes under_way_{};
  std::optional<double> begin_{};  ///< clock of the link at the first call [s]
  std::int64_t bytes_passed_ = 0;  ///< byte times, with those of silence
  std::int64_t frames_sent_ = 0;
  std::int64_t lost_writes_ = 0;
};

}  // namespace palpate::device::pressure_link
