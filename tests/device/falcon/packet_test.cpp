// SPDX-License-Identifier: MIT

#include "device/falcon/packet.hpp"

#include <random>

#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate::device::falcon;

PacketBytes bytes_of(std::string_view text) {
  PacketBytes bytes{};
  for (std::size_t n = 0; n < packet_bytes; ++n) { bytes[n] = static_cast<std::uint8_t>(text[n]); }
  return bytes;
}

// Expected bytes are written by hand from the published layout: '<', three words of four letters
// with the least significant nibble first (A = 0 ... P = 15), info, 'A', '>'.

TEST("motor words go out least significant nibble first, as letters from A") {
  const HostPacket idle{};
  CHECK(encode(idle) == bytes_of("<AAAAAAAAAAAAAA>"));
  const HostPacket request{.words = {0x1234, -1, 4096}, .homing = true};
  CHECK(encode(request) == bytes_of("<EDCBPPPPAAABBA>"));  // 4 3 2 1, F F F F, 0 0 0 1
  const HostPacket lowest{.words = {-32768, 32767, -4096}};
  CHECK(encode(lowest) == bytes_of("<AAAIPPPHAAAPAA>"));
}

TEST("flags have the bits of libnifalcon's code, above the letter A") {
  const auto info = [](const auto& packet) { return encode(packet)[13] - 0x41; };
  CHECK(info(HostPacket{.homing = true}) == 0x01);
  CHECK(info(HostPacket{.leds = {.green = true}}) == 0x02);
  CHECK(info(HostPacket{.leds = {.blue = true}}) == 0x04);
  CHECK(info(HostPacket{.leds = {.red = true}}) == 0x08);
  CHECK(info(DevicePacket{.buttons = {.plus = true}}) == 0x01);
  CHECK(info(DevicePacket{.buttons = {.forward = true}}) == 0x02);
  CHECK(info(DevicePacket{.buttons = {.centre = true}}) == 0x04);
  CHECK(info(DevicePacket{.buttons = {.minus = true}}) == 0x08);
  for (std::size_t leg = 0; leg < 3; ++leg) {
    DevicePacket packet;
    packet.homed[leg] = true;
    CHECK(info(packet) == 0x10 << leg);
  }
}

TEST("a device with all legs homed and no button pressed says B1, which is no letter") {
  PacketBytes expected = bytes_of("<AAAAAAAAAAAA.A>");
  expected[13] = 0xB1;
  CHECK(encode(DevicePacket{.homed = {true, true, true}}) == expected);
}

TEST("wire 0xFA59 is count -1447") {
  const auto packet = decode<DevicePacket>(bytes_of("<JFKPAAAAAAAAAA>"));  // 9 5 A F
  REQUIRE(packet.has_value());
  CHECK(packet->counts[0] == -1447);
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

template <class Packet> void every_info() {
  PacketBytes bytes = encode(Packet{});
  for (int info = 0; info < 256 - 0x41; ++info) {
    bytes[13] = static_cast<std::uint8_t>(0x41 + info);
    const auto packet = decode<Packet>(bytes);
    REQUIRE(packet.has_value() == (info <= Packet::most_info));
    if (packet) { CHECK(encode(*packet) == bytes); }
  }
}

TEST("every info value in range comes back as it was, and no other is taken") {
  every_info<HostPacket>();
  every_info<DevicePacket>();
}

TEST("no byte inside a packet of either direction can be a marker") {
  for (const std::uint8_t most_info : {HostPacket::most_info, DevicePacket::most_info}) {
    for (std::size_t place = 0; place < packet_bytes; ++place) {
      CHECK(may_stand(place, packet_begin, most_info) == (place == 0));
      CHECK(may_stand(place, packet_end, most_info) == (place == packet_bytes - 1));
    }
  }
}

TEST("any byte that is not allowed at its position makes the packet invalid") {
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

using Stream = std::vector<std::uint8_t>;

constexpr std::size_t frame_count = 1000;

/// The first word or count is the packet number, so that packets in wrong order are detected.
template <class Packet> std::vector<Packet> numbered_packets() {
  std::mt19937 generator(7);
  std::vector<Packet> packets(frame_count);
  for (std::size_t n = 0; n < frame_count; ++n) {
    const auto random = generator();
    const std::array numbers{static_cast<std::int16_t>(n), static_cast<std::int16_t>(random),
                             static_cast<std::int16_t>(random >> 16U)};
    if constexpr (std::is_same_v<Packet, DevicePacket>) {
      packets[n] = {.counts = numbers,
                    .buttons = {.plus = n % 2 == 0, .minus = n % 3 == 0},
                    .homed = {n % 5 != 0, n % 7 != 0, true}};
    } else {
      packets[n] = {.words = numbers, .homing = n % 2 == 0, .leds = {.red = n % 3 == 0}};
    }
  }
  return packets;
}

template <class Packet> Stream stream_of(const std::vector<Packet>& packets) {
  Stream stream;
  for (const Packet& packet : packets) {
    const PacketBytes bytes = encode(packet);
    stream.insert(stream.end(), bytes.begin(), bytes.end());
  }
  return stream;
}

enum class Harm { lost_or_doubled, changed };

/// Returns true if all packets except `hit` are decoded in order, and at most one in its position:
/// the same, or after a changed byte possibly another, since there is no checksum.
template <class Packet>
bool only_hit_is_lost(const std::vector<Packet>& packets, const Stream& stream, std::size_t hit,
                      Harm harm) {
  PacketReader<Packet> reader;
  std::vector<Packet> out;
  for (const std::uint8_t byte : stream) {
    if (const auto packet = reader.take(byte)) { out.push_back(*packet); }
  }
  const ReaderCounts& counts = reader.counts();
  const bool accounted =
      static_cast<std::int64_t>(stream.size()) ==
      16 * counts.frames + counts.skipped_bytes + static_cast<std::int64_t>(reader.pending_bytes());
  std::vector<Packet> others = packets;
  others.erase(others.begin() + static_cast<long>(hit));
  if (out.size() == packets.size()) {
    if (harm != Harm::changed && out[hit] != packets[hit]) { return false; }
    out.erase(out.begin() + static_cast<long>(hit));
  }
  return accounted && out == others;
}

/// Applies `change` to byte `place` of each of the 1000 frames, in a stream of two packets before
/// and two after. Packets further away are not affected.
template <class Packet, class Change> int streams_that_lose_more(Change change, Harm harm) {
  const std::vector<Packet> all = numbered_packets<Packet>();
  int failures = 0;
  for (std::size_t frame = 0; frame < all.size(); ++frame) {
    const std::size_t first = frame < 2 ? 0 : frame - 2;
    const std::size_t last = std::min(frame + 3, all.size());
    const std::vector<Packet> packets(all.begin() + static_cast<long>(first),
                                      all.begin() + static_cast<long>(last));
    const Stream whole = stream_of(packets);
    for (std::size_t place = 0; place < packet_bytes; ++place) {
      Stream stream = whole;
      change(stream, stream.begin() + static_cast<long>((frame - first) * packet_bytes + place));
      if (!only_hit_is_lost(packets, stream, frame - first, harm)) { ++failures; }
    }
  }
  return failures;
}

template <class Packet> void every_single_byte() {
  const auto erase = [](Stream& stream, auto at) { stream.erase(at); };
  const auto twice = [](Stream& stream, auto at) { stream.insert(at, *at); };
  CHECK(streams_that_lose_more<Packet>(erase, Harm::lost_or_doubled) == 0);
  CHECK(streams_that_lose_more<Packet>(twice, Harm::lost_or_doubled) == 0);
  for (const int value : {0x00, 0x3C, 0x3E, 0x41, 0x50, 0xB1, 0xFF}) {
    const auto set = [&](Stream&, auto at) { *at = static_cast<std::uint8_t>(value); };
    CHECK(streams_that_lose_more<Packet>(set, Harm::changed) == 0);
  }
}

TEST("one byte lost, doubled or changed anywhere loses at most the frame that was hit") {
  every_single_byte<DevicePacket>();
  every_single_byte<HostPacket>();
}

TEST("a packet is complete at its last byte, and giving up forgets the packet under way") {
  PacketReader<HostPacket> reader;
  const HostPacket request{.words = {1, 2, 3}};
  const PacketBytes bytes = encode(request);
  for (std::size_t n = 0; n + 1 < packet_bytes; ++n) { CHECK(!reader.take(bytes[n])); }
  CHECK(reader.take(bytes.back()) == request);
  (void)reader.take('<');
  (void)reader.take('A');
  reader.give_up();
  CHECK(reader.pending_bytes() == 0);
  CHECK((reader.counts() == ReaderCounts{.frames = 1, .bad_frames = 1, .skipped_bytes = 2}));
  CHECK(!reader.take('A'));
  CHECK(reader.counts().skipped_bytes == 3);
}

TEST("short packets, the kind that once read as buttons and homed legs, never come out") {
  PacketReader<DevicePacket> reader;
  const DevicePacket reply{.counts = {1, 2, 3}, .homed = {true, true, true}};
  const PacketBytes bytes = encode(reply);
  for (std::size_t length = 1; length < packet_bytes; ++length) {
    for (std::size_t n = 0; n < length; ++n) { CHECK(!reader.take(bytes[n])); }
    std::optional<DevicePacket> packet;
    for (const std::uint8_t byte : bytes) { packet = reader.take(byte); }
    CHECK(packet == reply);
  }
  CHECK(reader.counts().bad_frames == 15);
}

TEST("random bytes give no packet") {
  PacketReader<HostPacket> reader;
  std::mt19937 generator(1);
  int packets = 0;
  for (int n = 0; n < 1000000; ++n) {
    if (reader.take(static_cast<std::uint8_t>(generator()))) { ++packets; }
  }
  CHECK(packets == 0);  // chance of one in a million random bytes: 1e6 / 256^3 / 16^13 < 1e-16
  CHECK(reader.counts().skipped_bytes + static_cast<std::int64_t>(reader.pending_bytes()) ==
        1000000);
}

}  // namespace PALPATE_FILE
