// SPDX-License-Identifier: MIT
#include "device/falcon/packet.hpp"

#include <string_view>

#include "tests/check.hpp"

namespace {

using namespace palpate::device::falcon;

PacketBytes bytes_of(std::string_view text) {
  PacketBytes bytes{};
  for (std::size_t n = 0; n < packet_bytes; ++n) { bytes[n] = static_cast<std::uint8_t>(text[n]); }
  return bytes;
}

// Expected bytes are written down by hand from the published layout: '<', three words of four
// letters with the least significant nibble first (A = 0 ... P = 15), info, 'A', '>'.

TEST("motor words go out least significant nibble first, as letters from A") {
  const HostPacket idle{};
  CHECK(encode(idle) == bytes_of("<AAAAAAAAAAAAAA>"));
  const HostPacket request{.words = {0x1234, -1, 4096}, .homing = true};
  CHECK(encode(request) == bytes_of("<EDCBPPPPAAABBA>"));  // 4 3 2 1, F F F F, 0 0 0 1
  const HostPacket lowest{.words = {-32768, 32767, -4096}};
  CHECK(encode(lowest) == bytes_of("<AAAIPPPHAAAPAA>"));
}

TEST("homing is bit 1, green 2, blue 4, red 8, as libnifalcon's code has them") {
  CHECK(encode(HostPacket{.homing = true})[13] == 0x41 + 0x01);
  CHECK(encode(HostPacket{.leds = {.green = true}})[13] == 0x41 + 0x02);
  CHECK(encode(HostPacket{.leds = {.blue = true}})[13] == 0x41 + 0x04);
  CHECK(encode(HostPacket{.leds = {.red = true}})[13] == 0x41 + 0x08);
}

TEST("a device with all legs homed and no button pressed says B1, which is no letter") {
  const DevicePacket homed{.homed = {true, true, true}};
  CHECK(encode(homed)[13] == 0xB1);
  PacketBytes expected = bytes_of("<AAAAAAAAAAAA.A>");
  expected[13] = 0xB1;
  CHECK(encode(homed) == expected);
}

TEST("wire 0xFA59 is count -1447") {
  const auto packet = decode<DevicePacket>(bytes_of("<JFKPAAAAAAAAAA>"));  // 9 5 A F
  CHECK(packet.has_value());
  CHECK(packet && packet->counts[0] == -1447);
}

TEST("buttons are plus 1, forward 2, centre 4, minus 8; legs homed 10, 20, 40") {
  const auto info = [](const DevicePacket& packet) { return encode(packet)[13] - 0x41; };
  CHECK(info({.buttons = {.plus = true}}) == 0x01);
  CHECK(info({.buttons = {.forward = true}}) == 0x02);
  CHECK(info({.buttons = {.centre = true}}) == 0x04);
  CHECK(info({.buttons = {.minus = true}}) == 0x08);
  CHECK(info({.homed = {true, false, false}}) == 0x10);
  CHECK(info({.homed = {false, true, false}}) == 0x20);
  CHECK(info({.homed = {false, false, true}}) == 0x40);
}

TEST("every one of the 65536 words survives in every place, both ways") {
  int lost = 0;
  for (int value = -32768; value <= 32767; ++value) {
    const auto a = static_cast<std::int16_t>(value);
    const auto b = static_cast<std::int16_t>(~value);
    const HostPacket request{.words = {a, b, a}};
    const DevicePacket reply{.counts = {b, a, b}};
    if (decode<HostPacket>(encode(request)) != request) { ++lost; }
    if (decode<DevicePacket>(encode(reply)) != reply) { ++lost; }
  }
  CHECK(lost == 0);
}

template <class Packet>
void every_info() {
  PacketBytes bytes = encode(Packet{});
  for (int info = 0; info < 256 - 0x41; ++info) {
    bytes[13] = static_cast<std::uint8_t>(0x41 + info);
    const auto packet = decode<Packet>(bytes);
    CHECK(packet.has_value() == (info <= Packet::most_info));
    if (packet) { CHECK(encode(*packet) == bytes); }
  }
}

TEST("every info value in range comes back as it was, and no other is taken") {
  every_info<HostPacket>();
  every_info<DevicePacket>();
}

template <class Packet>
void no_marker_inside() {
  for (std::size_t place = 0; place < packet_bytes; ++place) {
    CHECK(may_stand(place, packet_begin, Packet::most_info) == (place == 0));
    CHECK(may_stand(place, packet_end, Packet::most_info) == (place == packet_bytes - 1));
  }
}

TEST("a marker may stand nowhere inside a packet of either direction") {
  no_marker_inside<HostPacket>();
  no_marker_inside<DevicePacket>();
}

TEST("any byte that may not stand at its place makes the packet invalid") {
  const HostPacket request{.words = {1, -2, 300}, .homing = true, .leds = {.blue = true}};
  for (std::size_t place = 0; place < packet_bytes; ++place) {
    for (int value = 0; value < 256; ++value) {
      PacketBytes bytes = encode(request);
      bytes[place] = static_cast<std::uint8_t>(value);
      const bool letter = value >= 'A' && value <= 'P';
      const bool allowed = place == 0    ? value == '<'
                           : place == 15 ? value == '>'
                           : place == 14 ? value == 'A'
                                         : letter;
      CHECK(decode<HostPacket>(bytes).has_value() == allowed);
    }
  }
}

}  // namespace
