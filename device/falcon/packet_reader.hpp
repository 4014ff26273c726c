// SPDX-License-Identifier: MIT
#pragma once
/// Packets out of a stream of bytes that may come in pieces, with bytes lost, doubled, changed or
/// foreign. '<' stands nowhere inside a packet, so it always begins one, and a byte that may not
/// stand where it came ends the attempt: only packets that were hit themselves are lost.
/// There is no checksum: a nibble that was changed into another nibble goes through.

#include <cstdint>
#include <optional>

#include "device/falcon/packet.hpp"

namespace palpate::device::falcon {

/// bytes taken = 16 frames + skipped_bytes + bytes of the packet that is under way.
struct ReaderCounts {
  std::int64_t frames = 0;         ///< well-formed packets
  std::int64_t bad_frames = 0;     ///< begun with '<' and given up
  std::int64_t skipped_bytes = 0;  ///< of bad frames and between packets
  bool operator==(const ReaderCounts&) const = default;
};

/// Packet is HostPacket (on the device's side) or DevicePacket (on the host's).
template <class Packet>
class PacketReader {
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
