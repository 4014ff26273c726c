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
/// On 9600 baud 8N1 a byte takes ten bits: 960 bytes/s, 120 frames/s, which leaves the line no
/// pause.

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

/// CRC-16/CCITT-FALSE: polynomial 1021, begun with FFFF, not reflected, nothing added at the end.
/// Of the nine characters "123456789" it is 29B1.
std::uint16_t checksum(std::span<const std::uint8_t> bytes) noexcept;

FrameBytes encode(const Frame& frame) noexcept;
/// Nothing when the beginning or the checksum is not that of a frame. Unknown status bits pass.
std::optional<Frame> decode(std::span<const std::uint8_t, frame_bytes> bytes) noexcept;

// Frames out of a stream of bytes that may come in pieces, with bytes lost, doubled, changed or
// foreign. Of a frame that fails its check only the first byte is thrown away and the rest is
// looked through again, so that no frame is lost that was not hit itself. Foreign bytes that look
// like a frame pass their checksum with a chance of 2^-16.

/// bytes taken = 8 (frames + repeated) + skipped_bytes + bytes of the frame that is under way.
struct ReaderCounts {
  std::int64_t frames = 0;    ///< good ones
  std::int64_t repeated = 0;  ///< good, but the same bytes as the frame before; left out
  /// Each beginning of a frame that failed its check; one for a run of skipped bytes without any.
  std::int64_t bad_frames = 0;
  std::int64_t missing = 0;  ///< that the sequence numbers say were sent between good ones
  std::int64_t gaps = 0;     ///< places where they are missing
  std::int64_t skipped_bytes = 0;
  std::int64_t over_range = 0;   ///< good frames that say so
  std::int64_t battery_low = 0;  ///< good frames that say so
  bool operator==(const ReaderCounts&) const = default;
};

/// Sequence numbers tell how many frames are missing only up to a multiple of 256, which is 2.1 s
/// of line: from bytes alone a longer gap looks shorter by such multiples. Where arrival times are
/// known, frames_since() settles that.
struct ReceivedFrame {
  Frame frame{};
  int missing_before = 0;  ///< 0 to 255, since the good frame before
};

class FrameReader {
 public:
  /// Takes one byte; the frame that it completes, if it does.
  std::optional<ReceivedFrame> take(std::uint8_t byte) noexcept;
  /// After the last byte: a frame that is under way will never be complete.
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
  bool skipping_ = false;        ///< bytes were skipped since the last good frame
  bool began_ = false;           ///< and the beginning of a frame was among them
  std::optional<Frame> last_{};  ///< good frame
  ReaderCounts counts_{};
};

/// Frame periods from one good frame to the next: the number that agrees with both sequence numbers
/// and lies nearest to the time between their arrivals [s].
std::int64_t frames_since(const ReceivedFrame& received, double elapsed_s) noexcept;

}  // namespace palpate::device::pressure_link
