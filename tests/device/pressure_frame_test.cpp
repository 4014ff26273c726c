// SPDX-License-Identifier: MIT
#include "device/pressure_link/frame.hpp"

#include <string_view>
#include <vector>

#include "tests/check.hpp"

namespace {

using namespace palpate::device::pressure_link;

/// Long division of the message, 16 zeros behind it, by x^16 + x^12 + x^5 + 1 over GF(2), the first
/// 16 bits inverted: what CRC-16/CCITT-FALSE is by definition.
unsigned remainder_of(const std::vector<std::uint8_t>& bytes) {
  std::vector<int> bits;
  for (const std::uint8_t byte : bytes) {
    for (int bit = 7; bit >= 0; --bit) { bits.push_back((byte >> bit) & 1); }
  }
  bits.resize(bits.size() + 16, 0);
  for (std::size_t n = 0; n < 16; ++n) { bits[n] ^= 1; }
  for (std::size_t n = 0; n + 16 < bits.size(); ++n) {
    if (bits[n] == 0) { continue; }
    for (const std::size_t power : {0U, 4U, 11U, 16U}) { bits[n + power] ^= 1; }
  }
  unsigned rest = 0;
  for (std::size_t n = bits.size() - 16; n < bits.size(); ++n) {
    rest = (rest << 1U) | static_cast<unsigned>(bits[n]);
  }
  return rest;
}

TEST("the checksum is the published check value, and the remainder of long division") {
  const std::string_view digits = "123456789";
  CHECK(checksum({reinterpret_cast<const std::uint8_t*>(digits.data()), digits.size()}) == 0x29B1);
  for (unsigned n = 0; n < 2000; ++n) {
    const std::vector<std::uint8_t> bytes{
        static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 3U),
        static_cast<std::uint8_t>(n * 97U), static_cast<std::uint8_t>(n * 31U)};
    CHECK(checksum(bytes) == remainder_of(bytes));
  }
}

TEST("a frame's bytes stand where the format has them") {
  // 461.0 mmHg is 4610 = 1202 hexadecimal.
  const FrameBytes bytes = encode({.sequence = 0x7F, .battery_low = true, .pressure = 4610});
  const unsigned sum = remainder_of({0x7F, 0x02, 0x02, 0x12});
  CHECK((bytes == FrameBytes{0xA5, 0x5A, 0x7F, 0x02, 0x02, 0x12,
                             static_cast<std::uint8_t>(sum & 0xFFU),
                             static_cast<std::uint8_t>(sum >> 8U)}));
  const FrameBytes negative = encode({.over_range = true, .pressure = -1});
  CHECK(negative[3] == 0x01 && negative[4] == 0xFF && negative[5] == 0xFF);
}

TEST("every frame comes back as it was, of every pressure and every sequence number") {
  for (int pressure = -32768; pressure <= 32767; ++pressure) {
    const Frame frame{.sequence = static_cast<std::uint8_t>(pressure),
                      .over_range = pressure % 3 == 0,
                      .battery_low = pressure % 5 == 0,
                      .pressure = static_cast<std::int16_t>(pressure)};
    if (decode(encode(frame)) != frame) { CHECK(decode(encode(frame)) == frame); }
  }
  CHECK(decode(encode({.sequence = 255})).has_value());
}

TEST("no frame survives one changed byte, nor any two changed bits") {
  // The polynomial has the factor x + 1 and order 32767: every one- and two-bit error and every
  // burst of up to 16 bits shows.
  const FrameBytes good = encode({.sequence = 200, .pressure = -1234});
  for (std::size_t place = 0; place < frame_bytes; ++place) {
    for (unsigned change = 1; change < 256; ++change) {
      FrameBytes bad = good;
      bad[place] = static_cast<std::uint8_t>(bad[place] ^ change);
      CHECK(!decode(bad).has_value());
    }
  }
  for (std::size_t a = 0; a < 8 * frame_bytes; ++a) {
    for (std::size_t b = a + 1; b < 8 * frame_bytes; ++b) {
      FrameBytes bad = good;
      bad[a / 8] = static_cast<std::uint8_t>(bad[a / 8] ^ (1U << (a % 8)));
      bad[b / 8] = static_cast<std::uint8_t>(bad[b / 8] ^ (1U << (b % 8)));
      CHECK(!decode(bad).has_value());
    }
  }
}

TEST("eight bytes at 960 bytes a second are 120 frames a second") {
  CHECK(bytes_per_second == 9600.0 / 10.0);  // one start bit, eight of data, one stop bit
  CHECK(frames_per_second == 120.0);
}

}  // namespace
