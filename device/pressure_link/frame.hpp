// SPDX-License-Identifier: MIT
#pragma once
/// The frame of the raw pressure link (docs/formats.md), 8 bytes a sample:
///
///   bytes 0-1    A5 5A
///   byte 2       sequence, wraps at 256
///   byte 3       status: bit 0 over-range, bit 1 battery low
///   bytes 4-5    pressure, signed, least significant byte first, 0.1 mmHg
///   bytes 6-7    CRC-16/CCITT-FALSE of bytes 2-5, least significant byte first
///
/// At 9600 baud 8N1 a byte takes ten bits: 960 bytes/s, 120 frames/s without a pause.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace palpate::device::pressure_link {

inline constexpr std::size_t frame_bytes = 8;
inline constexpr std::array<std::uint8_t, 2> frame_begin{0xA5, 0x5A};
inline constexpr double bytes_per_second = 960.0;                                    ///< [1/s]
inline constexpr double frames_per_second = bytes_per_second / double{frame_bytes};  ///< [1/s]
using FrameBytes = std::array<std::uint8_t, frame_bytes>;

struct Frame {
  std::uint8_t sequence = 0;
  bool over_range = false;
  bool battery_low = false;
  std::int16_t pressure = 0;  ///< gauge [0.1 mmHg]
  bool operator==(const Frame&) const = default;
};

/// Computes CRC-16/CCITT-FALSE: polynomial 1021, initial value FFFF, not reflected, no final XOR.
/// The value for the nine characters "123456789" is 29B1.
std::uint16_t checksum(std::span<const std::uint8_t> bytes) noexcept;

FrameBytes encode(const Frame& frame) noexcept;
/// Returns the frame, or nothing if the start bytes or the checksum are wrong. Unknown status bits
/// are ignored.
std::optional<Frame> decode(std::span<const std::uint8_t, frame_bytes> bytes) noexcept;

// Decoder for a byte stream that may arrive in pieces and with lost, repeated, changed or foreign
// bytes. If a frame fails its check, only its first byte is discarded and the rest is searched
// again, so an undamaged frame is never lost. Foreign bytes that look like a frame pass the
// checksum with a probability of 2^-16.

/// Counts of a frame reader: bytes taken = 8 (frames + repeated) + skipped_bytes + bytes of the
/// incomplete frame.
struct ReaderCounts {
  std::int64_t frames = 0;    ///< valid frames
  std::int64_t repeated = 0;  ///< valid, but identical to the previous frame; omitted
  /// Number of frame starts that failed the check; a run of skipped bytes without a start counts
  /// once.
  std::int64_t bad_frames = 0;
  std::int64_t missing = 0;  ///< missing frames, from the sequence numbers
  std::int64_t gaps = 0;     ///< number of gaps with missing frames
  std::int64_t skipped_bytes = 0;
  std::int64_t over_range = 0;   ///< valid frames with this status
  std::int64_t battery_low = 0;  ///< valid frames with this status
  bool operator==(const ReaderCounts&) const = default;
};

/// Valid frame with the number of missing frames before it. Sequence numbers give that number only
/// modulo 256, which is 2.1 s of line. If arrival times are available, frames_since() resolves the
/// ambiguity.
struct ReceivedFrame {
  Frame frame{};
  int missing_before = 0;  ///< 0 to 255, since the previous valid frame
};

class FrameReader {
 public:
  /// Processes one byte; returns the frame if this byte completes one.
  std::optional<ReceivedFrame> take(std::uint8_t byte) noexcept;
  /// Ends the stream: an incomplete frame is counted as skipped bytes.
  void finish() noexcept;

  [[nodiscard]] const ReaderCounts& counts() const noexcept { return counts_; }
  [[nodiscard]] std::size_t pending_bytes() const noexcept { return filled_; }

 private:
  [[nodiscard]] bool may_begin_frame() const noexcept;
  void skip_one() noexcept;
  void skip_to_beginning() noexcept;
  void end_skipping() noexcept;
  std::optional<ReceivedFrame> accept(const Frame& frame) noexcept;

  FrameBytes bytes_{};
  std::size_t filled_ = 0;
  bool skipping_ = false;        ///< bytes were skipped since the last valid frame
  bool began_ = false;           ///< the skipped bytes contained the start of a frame
  std::optional<Frame> last_{};  ///< last valid frame
  ReaderCounts counts_{};
};

/// Returns the frame periods from one valid frame to the next: the number that agrees with both
/// sequence numbers and is nearest to the time between their arrivals `elapsed_s` [s].
std::int64_t frames_since(const ReceivedFrame& received, double elapsed_s) noexcept;

}  // namespace palpate::device::pressure_link
