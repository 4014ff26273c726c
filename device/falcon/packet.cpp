// SPDX-License-Identifier: MIT

#include "device/falcon/packet.hpp"

#include <initializer_list>

namespace palpate::device::falcon {
namespace {

constexpr std::uint8_t zero = 0x41;  // 'A'
constexpr std::size_t nibbles = 4;   // of one number
constexpr std::size_t info_place = 13;
constexpr std::size_t unused_place = 14;

using Numbers = std::array<std::int16_t, 3>;

std::uint8_t bits(std::initializer_list<bool> flags) noexcept {
  unsigned sum = 0;
  unsigned place = 0;
  for (const bool flag : flags) { sum |= unsigned{flag} << place++; }
  return static_cast<std::uint8_t>(sum);
}

bool has(unsigned bits, unsigned place) noexcept { return ((bits >> place) & 1U) != 0; }

PacketBytes framed(const Numbers& numbers, std::uint8_t info) noexcept {
  PacketBytes bytes{};
  bytes.front() = packet_begin;
  std::size_t place = 1;
  for (const std::int16_t number : numbers) {
    for (unsigned rest = static_cast<std::uint16_t>(number), n = 0; n < nibbles; ++n, rest >>= 4U) {
      bytes[place++] = static_cast<std::uint8_t>((rest & 0x0FU) + zero);
    }
  }
  bytes[info_place] = static_cast<std::uint8_t>(info + zero);
  bytes[unused_place] = zero;
  bytes.back() = packet_end;
  return bytes;
}

Numbers numbers_of(const PacketBytes& bytes) noexcept {
  Numbers numbers{};
  for (std::size_t n = 0; n < numbers.size(); ++n) {
    unsigned value = 0;
    for (std::size_t digit = nibbles; digit-- > 0;) {
      value = (value << 4U) | (bytes[1 + nibbles * n + digit] - unsigned{zero});
    }
    numbers[n] = static_cast<std::int16_t>(static_cast<std::uint16_t>(value));
  }
  return numbers;
}

HostPacket read(const Numbers& numbers, unsigned info, const HostPacket&) noexcept {
  return {.words = numbers,
          .homing = has(info, 0),
          .leds = {.green = has(info, 1), .blue = has(info, 2), .red = has(info, 3)}};
}

DevicePacket read(const Numbers& numbers, unsigned info, const DevicePacket&) noexcept {
  return {.counts = numbers,
          .buttons = {.plus = has(info, 0),
                      .forward = has(info, 1),
                      .centre = has(info, 2),
                      .minus = has(info, 3)},
          .homed = {has(info, 4), has(info, 5), has(info, 6)}};
}

}  // namespace

std::uint8_t info_bits(const HostPacket& packet) noexcept {
  return bits({packet.homing, packet.leds.green, packet.leds.blue, packet.leds.red});
}

std::uint8_t info_bits(const DevicePacket& packet) noexcept {
  const auto& [plus, forward, centre, minus] = packet.buttons;
  return bits({plus, forward, centre, minus, packet.homed[0], packet.homed[1], packet.homed[2]});
}

PacketBytes encode(const HostPacket& packet) noexcept {
  return framed(packet.words, info_bits(packet));
}

PacketBytes encode(const DevicePacket& packet) noexcept {
  return framed(packet.counts, info_bits(packet));
}

bool may_stand(std::size_t place, std::uint8_t byte, std::uint8_t most_info) noexcept {
  constexpr unsigned most_nibble = 0x0F;
  switch (place) {
    case 0: return byte == packet_begin;
    case info_place: return byte >= zero && byte <= most_info + unsigned{zero};
    case unused_place: return byte == zero;
    case packet_bytes - 1: return byte == packet_end;
    default: return place < packet_bytes && byte >= zero && byte <= most_nibble + zero;
  }
}

template <class Packet> std::optional<Packet> decode(const PacketBytes& bytes) noexcept {
  for (std::size_t place = 0; place < packet_bytes; ++place) {
    if (!may_stand(place, bytes[place], Packet::most_info)) { return std::nullopt; }
  }
  return read(numbers_of(bytes), bytes[info_place] - unsigned{zero}, Packet{});
}

template std::optional<HostPacket> decode(const PacketBytes& bytes) noexcept;
template std::optional<DevicePacket> decode(const PacketBytes& bytes) noexcept;

}  // namespace palpate::device::falcon
