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
/// No byte of a well-formed packet but its first is '<', and none but its last is '>'.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace palpate::device::falcon {

inline constexpr std::size_t packet_bytes = 16;
inline constexpr std::uint8_t packet_begin = 0x3C;  ///< '<'
inline constexpr std::uint8_t packet_end = 0x3E;    ///< '>'
using PacketBytes = std::array<std::uint8_t, packet_bytes>;

struct Leds {
  bool green = false;
  bool blue = false;
  bool red = false;
  bool operator==(const Leds&) const = default;
};

/// From far right to far left: plus, forward, centre (with the logo; nearest to the user), minus.
struct Buttons {
  bool plus = false;
  bool forward = false;
  bool centre = false;
  bool minus = false;
  bool operator==(const Buttons&) const = default;
};

/// Pressed in one or the other.
constexpr Buttons operator|(const Buttons& a, const Buttons& b) noexcept {
  return {.plus = a.plus || b.plus,
          .forward = a.forward || b.forward,
          .centre = a.centre || b.centre,
          .minus = a.minus || b.minus};
}

/// What the host asks for. Homing stays on only while every packet asks for it.
struct HostPacket {
  static constexpr std::uint8_t most_info = 0x0F;  ///< homing 1, green 2, blue 4, red 8
  std::array<std::int16_t, 3> words{};             ///< motors of legs 1-3; positive pulls inward
  bool homing = false;
  Leds leds{};
  bool operator==(const HostPacket&) const = default;
};

/// What the device answers.
struct DevicePacket {
  static constexpr std::uint8_t most_info = 0x7F;  ///< plus 1 ... minus 8, homed legs 10, 20, 40
  std::array<std::int16_t, 3> counts{};            ///< encoders of legs 1-3; they grow outward
  Buttons buttons{};
  std::array<bool, 3> homed{};
  bool operator==(const DevicePacket&) const = default;
};

/// The bits of byte 13 before 41 is added.
std::uint8_t info_bits(const HostPacket& packet) noexcept;
std::uint8_t info_bits(const DevicePacket& packet) noexcept;

PacketBytes encode(const HostPacket& packet) noexcept;
PacketBytes encode(const DevicePacket& packet) noexcept;

/// Whether the byte may stand at this place of a packet whose info bits are at most `most_info`.
bool may_stand(std::size_t place, std::uint8_t byte, std::uint8_t most_info) noexcept;

/// Nothing when a byte stands where it may not. Instances: HostPacket and DevicePacket.
template <class Packet> std::optional<Packet> decode(const PacketBytes& bytes) noexcept;

// Packets out of a stream of bytes that may come in pieces, with bytes lost, doubled, changed or
// foreign. '<' stands nowhere inside a packet, so it always begins one, and a byte that may not
// stand where it came ends the attempt: only packets that were hit themselves are lost.
// There is no checksum: a nibble that was changed into another nibble goes through.

/// bytes taken = 16 frames + skipped_bytes + bytes of the packet that is under way.
struct ReaderCounts {
  std::int64_t frames = 0;         ///< well-formed packets
  std::int64_t bad_frames = 0;     ///< begun with '<' and given up
  std::int64_t skipped_bytes = 0;  ///< of bad frames and between packets
  bool operator==(const ReaderCounts&) const = default;
};

/// Packet is HostPacket (on the device's side) or DevicePacket (on the host's).
template <class Packet> class PacketReader {
 public:
  /// Takes one byte; the packet that it completes, if it does.
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

  /// Forgets the packet that is under way, as after a break of the line.
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
