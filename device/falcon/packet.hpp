// SPDX-License-Identifier: MIT
#pragma once
/// The two packets of a Falcon's run phase, 16 bytes each way (libnifalcon's FalconComm and its
/// firmware class, checked against recorded bytes):
///
///   byte 0       3C '<'
///   bytes 1-12   three signed 16 bit numbers, least significant nibble first, nibble + 41
///   byte 13      info bits + 41
///   byte 14      41, unused
///   byte 15      3E '>'
///
/// In a well-formed packet, only the first byte is '<' and only the last is '>'.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace palpate::device::falcon {

inline constexpr std::size_t packet_bytes = 16;
inline constexpr std::uint8_t packet_begin = 0x3C;  ///< '<'
inline constexpr std::uint8_t packet_end = 0x3E;    ///< '>'
using PacketBytes = std::array<std::uint8_t, packet_bytes>;

// Bytes of the boot phase.
inline constexpr std::array<std::uint8_t, 3> hail_request{0x0A, 0x43, 0x0D};
inline constexpr std::array<std::uint8_t, 4> hail_reply{0x0A, 0x44, 0x2C, 0x0D};
inline constexpr std::uint8_t load_request = 0x41;  ///< echoed

struct Leds {
  bool green = false;
  bool blue = false;
  bool red = false;
  bool operator==(const Leds&) const = default;
};

/// Buttons from far right to far left: plus, forward, centre (with the logo, nearest to the user),
/// minus.
struct Buttons {
  bool plus = false;
  bool forward = false;
  bool centre = false;
  bool minus = false;
  bool operator==(const Buttons&) const = default;
};

/// Returns the buttons that are pressed in either operand.
constexpr Buttons operator|(const Buttons& a, const Buttons& b) noexcept {
  return {.plus = a.plus || b.plus,
          .forward = a.forward || b.forward,
          .centre = a.centre || b.centre,
          .minus = a.minus || b.minus};
}

/// Packet from the host. Homing is on only while every packet requests it.
struct HostPacket {
  static constexpr std::uint8_t most_info = 0x0F;  ///< homing 1, green 2, blue 4, red 8
  std::array<std::int16_t, 3> words{};             ///< motors of legs 1-3; positive pulls inward
  bool homing = false;
  Leds leds{};
  bool operator==(const HostPacket&) const = default;
};

/// Packet from the device.
struct DevicePacket {
  static constexpr std::uint8_t most_info = 0x7F;  ///< plus 1 ... minus 8, homed legs 10, 20, 40
  std::array<std::int16_t, 3> counts{};            ///< encoders of legs 1-3; positive outward
  Buttons buttons{};
  std::array<bool, 3> homed{};
  bool operator==(const DevicePacket&) const = default;
};

/// Returns the bits of byte 13 before 41 is added.
std::uint8_t info_bits(const HostPacket& packet) noexcept;
std::uint8_t info_bits(const DevicePacket& packet) noexcept;

PacketBytes encode(const HostPacket& packet) noexcept;
PacketBytes encode(const DevicePacket& packet) noexcept;

/// Returns true if the byte is valid at this position of a packet whose info bits are at most
/// `most_info`.
bool may_stand(std::size_t place, std::uint8_t byte, std::uint8_t most_info) noexcept;

/// Returns the packet, or nothing if a byte is not valid at its position. Instances: HostPacket and
/// DevicePacket.
template <class Packet> std::optional<Packet> decode(const PacketBytes& bytes) noexcept;

// Decoder for a byte stream that may arrive in pieces and with lost, repeated, changed or foreign
// bytes. '<' always begins a packet, and an invalid byte ends the attempt, so only damaged packets
// are lost. There is no checksum: a nibble changed into another valid nibble is not detected.

/// Counts of a packet reader: bytes taken = 16 frames + skipped_bytes + bytes of the incomplete
/// packet.
struct ReaderCounts {
  std::int64_t frames = 0;         ///< well-formed packets
  std::int64_t bad_frames = 0;     ///< begun with '<' and abandoned
  std::int64_t skipped_bytes = 0;  ///< in bad frames and between packets
  bool operator==(const ReaderCounts&) const = default;
};

/// Decoder of HostPacket (device side) or DevicePacket (host side).
template <class Packet> class PacketReader {
 public:
  /// Processes one byte; returns the packet if this byte completes one.
  std::optional<Packet> take(std::uint8_t byte) noexcept {
    if (byte == packet_begin) {
      give_up();
    } else if (filled_ == 0 || !may_stand(filled_, byte, Packet::most_info)) {
      ++counts_.skipped_bytes;
      give_up();
      return std::nullopt;
    }
    bytes_[filled_++] = byte;
    if (filled_ < packet_bytes) { return std::nullopt; }
    ++counts_.frames;
    filled_ = 0;
    return decode<Packet>(bytes_);
  }

  /// Discards the incomplete packet, as after an interruption of the line.
  void give_up() noexcept {
    if (filled_ == 0) { return; }
    ++counts_.bad_frames;
    counts_.skipped_bytes += static_cast<std::int64_t>(filled_);
    filled_ = 0;
  }

  [[nodiscard]] const ReaderCounts& counts() const noexcept { return counts_; }
  [[nodiscard]] std::size_t pending_bytes() const noexcept { return filled_; }

 private:
  PacketBytes bytes_{};
  std::size_t filled_ = 0;
  ReaderCounts counts_{};
};

}  // namespace palpate::device::falcon
