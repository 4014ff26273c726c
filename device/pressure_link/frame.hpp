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
/// On 9600 baud 8N1 a byte takes ten bits: 960 bytes/s, 120 frames/s, which leaves the line no pause.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace palpate::device::pressure_link {

inline constexpr std::size_t frame_bytes = 8;
inline constexpr std::array<std::uint8_t, 2> frame_begin{0xA5, 0x5A};
inline constexpr double bytes_per_second = 960.0;  ///< [1/s]
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

}  // namespace palpate::device::pressure_link
