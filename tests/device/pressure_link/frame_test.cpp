// SPDX-License-Identifier: MIT

#include "device/pressure_link/frame.hpp"

#include <set>

#include "device/seeded.hpp"
#include "tests/check.hpp"

namespace PALPATE_FILE {

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

TEST("a frame's bytes are in the places of the format, at its rate") {
  CHECK(bytes_per_second == 9600.0 / 10.0);  // one start bit, eight of data, one stop bit
  CHECK(frames_per_second == 120.0);
  // 461.0 mmHg is 4610 = 1202 hexadecimal.
  const FrameBytes bytes = encode({.sequence = 0x7F, .battery_low = true, .pressure = 4610});
  const unsigned sum = remainder_of({0x7F, 0x02, 0x02, 0x12});
  CHECK((bytes == FrameBytes{0xA5, 0x5A, 0x7F, 0x02, 0x02, 0x12,
                             static_cast<std::uint8_t>(sum & 0xFFU),
                             static_cast<std::uint8_t>(sum >> 8U)}));
  const FrameBytes negative = encode({.over_range = true, .pressure = -1});
  CHECK(negative[3] == 0x01);
  CHECK(negative[4] == 0xFF);
  CHECK(negative[5] == 0xFF);
}

TEST("every frame comes back as it was, of every pressure and every sequence number") {
  for (int pressure = -32768; pressure <= 32767; ++pressure) {
    const Frame frame{.sequence = static_cast<std::uint8_t>(pressure),
                      .over_range = pressure % 3 == 0,
                      .battery_low = pressure % 5 == 0,
                      .pressure = static_cast<std::int16_t>(pressure)};
    CHECK((decode(encode(frame)) == frame));
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

using Bytes = std::vector<std::uint8_t>;

/// Frame n has the sequence number n and a pressure of n times `step`.
Bytes stream_of(int frames, int step = 1) {
  Bytes bytes;
  for (int n = 0; n < frames; ++n) {
    const FrameBytes one = encode({.sequence = static_cast<std::uint8_t>(n),
                                   .pressure = static_cast<std::int16_t>(step * n)});
    bytes.insert(bytes.end(), one.begin(), one.end());
  }
  return bytes;
}

struct Heard {
  std::vector<int> frames{};
  std::int64_t places = 0;  ///< position of the last frame, by sequence numbers
  ReaderCounts counts{};
};

Heard heard(const Bytes& bytes) {
  FrameReader reader;
  Heard result;
  for (const std::uint8_t byte : bytes) {
    if (const auto received = reader.take(byte)) {
      result.frames.push_back(received->frame.pressure);
      result.places += 1 + received->missing_before;
    }
  }
  reader.finish();
  result.counts = reader.counts();
  const auto all = static_cast<std::int64_t>(bytes.size());
  CHECK(8 * (result.counts.frames + result.counts.repeated) + result.counts.skipped_bytes == all);
  return result;
}

Bytes without(Bytes bytes, std::size_t place) {
  bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(place));
  return bytes;
}

TEST("a clean stream gives every frame and nothing else") {
  const Heard clean = heard(stream_of(1000));
  REQUIRE(clean.frames.size() == 1000);
  CHECK(clean.frames.front() == 0);
  CHECK(clean.frames.back() == 999);
  CHECK((clean.counts == ReaderCounts{.frames = 1000}));
}

/// First and last position of the run of equal bytes around a byte; the stream does not show which
/// of them was lost or doubled.
std::array<std::size_t, 2> equal_run(const Bytes& bytes, std::size_t place) {
  std::array run{place, place};
  while (run[0] > 0 && bytes[run[0] - 1] == bytes[place]) { --run[0]; }
  while (run[1] + 1 < bytes.size() && bytes[run[1] + 1] == bytes[place]) { ++run[1]; }
  return run;
}

constexpr int step = 3;

void costs_one_frame(const Bytes& bytes, int frames, int hit) {
  const Heard result = heard(bytes);
  std::vector<int> expected;
  for (int n = 0; n < frames; ++n) {
    if (n != hit) { expected.push_back(step * n); }
  }
  CHECK(result.frames == expected);
  CHECK(result.places == frames);
  CHECK(result.counts.frames + result.counts.missing == frames);
  CHECK(result.counts.bad_frames >= 1);
  CHECK(result.counts.bad_frames <= 2);
}

TEST("any one byte lost, doubled or changed costs the frame that it was in and no other") {
  constexpr int frames = 300;  // sequence numbers wrap on the way
  const Bytes good = stream_of(frames, step);
  for (std::size_t place = 8; place < good.size() - 8; ++place) {
    const auto [begin, end] = equal_run(good, place);
    costs_one_frame(without(good, place), frames, static_cast<int>(end / 8));
    Bytes changed = good;
    changed[place] = static_cast<std::uint8_t>(changed[place] + 1 + place % 255);
    costs_one_frame(changed, frames, static_cast<int>(place / 8));
    Bytes doubled = good;
    doubled.insert(doubled.begin() + static_cast<std::ptrdiff_t>(place), good[place]);
    // A duplicate of the same byte before the first byte of a frame or after its last has no
    // effect.
    const bool harmless = begin % 8 == 0 || end % 8 == 7 || begin / 8 != end / 8;
    costs_one_frame(doubled, frames, harmless ? -1 : static_cast<int>(place / 8));
  }
}

TEST("what is left of a hit frame may pass its checksum, once in 65536") {
  // Frame 142 of pressures 0, 1, 2 ... without its last byte of pressure: found among 2400 streams.
  const Heard result = heard(without(stream_of(300), 142 * 8 + 5));
  CHECK(result.counts.frames == 299);
  CHECK(result.counts.missing == 1);
  CHECK(result.frames[142] == 0x358E);  // in place of 142, and 143 has lost its first byte to it
}

TEST("a stream that begins or ends in the middle of a frame loses it alone, as a bad one") {
  const Bytes good = stream_of(20);
  for (std::ptrdiff_t cut = 1; cut < 8; ++cut) {
    const Heard late = heard(Bytes(good.begin() + cut, good.end()));
    REQUIRE(late.frames.size() == 19);
    CHECK(late.frames.front() == 1);
    CHECK((late.counts == ReaderCounts{.frames = 19, .bad_frames = 1, .skipped_bytes = 8 - cut}));
    const Heard early = heard(Bytes(good.begin(), good.end() - cut));
    CHECK((early.counts == ReaderCounts{.frames = 19, .bad_frames = 1, .skipped_bytes = 8 - cut}));
  }
}

TEST("the start bytes of a frame within a pressure or a checksum do no harm") {
  // 5AA5 hexadecimal, sent as A5 5A, in every frame: each is also a beginning at its fourth byte.
  Bytes bytes{0xA5, 0x5A, 0x00};
  for (int n = 0; n < 400; ++n) {
    const FrameBytes one =
        encode({.sequence = static_cast<std::uint8_t>(n), .pressure = std::int16_t{0x5AA5}});
    bytes.insert(bytes.end(), one.begin(), one.end());
  }
  const Heard result = heard(bytes);
  CHECK(result.counts.frames == 400);
  CHECK(result.counts.missing == 0);
}

TEST("lost frames are counted by their sequence numbers, over the wrap as well") {
  const Bytes good = stream_of(600);
  for (const std::ptrdiff_t lost : {1, 2, 50, 255}) {
    Bytes bytes = good;
    bytes.erase(bytes.begin() + 8 * 200, bytes.begin() + 8 * (200 + lost));
    const Heard result = heard(bytes);
    CHECK(result.counts.missing == lost);
    CHECK(result.counts.gaps == 1);
    CHECK(result.counts.frames + result.counts.missing == 600);
    CHECK(result.counts.bad_frames == 0);
  }
}

TEST("a gap of more than 255 frames looks shorter by 256 unless the time is known") {
  FrameReader reader;
  const auto take = [&](int n) {
    std::optional<ReceivedFrame> received;
    for (const std::uint8_t byte : encode({.sequence = static_cast<std::uint8_t>(n),
                                   .pressure = static_cast<std::int16_t>(n)})) {
      received = reader.take(byte);
    }
    return *received;
  };
  take(10);
  const ReceivedFrame next = take(10 + 300);  // 299 are missing
  CHECK(next.missing_before == 299 - 256);
  for (const double late : {-0.5, 0.0, 0.5}) {  // a second is less than half of 256 frames
    CHECK(frames_since(next, 300.0 / 120.0 + late) == 300);
  }
  CHECK(frames_since(next, 44.0 / 120.0) == 44);
  CHECK(frames_since(next, 0.0) == 44);  // never less than the sequence numbers say
}

TEST("a repeated frame is counted once") {
  Bytes bytes = stream_of(4);
  bytes.insert(bytes.begin() + 16, bytes.begin() + 8, bytes.begin() + 16);
  const Heard result = heard(bytes);
  CHECK((result.frames == std::vector<int>{0, 1, 2, 3}));
  CHECK(result.counts.repeated == 1);
  CHECK(result.counts.missing == 0);
}

TEST("status bits are counted, and unknown ones do no harm") {
  Bytes bytes;
  for (int n = 0; n < 10; ++n) {
    FrameBytes one = encode({.sequence = static_cast<std::uint8_t>(n),
                             .over_range = n == 3 || n == 4,
                             .battery_low = n > 6});
    one[3] = static_cast<std::uint8_t>(one[3] | 0xF0U);
    const std::uint16_t sum = checksum({one.data() + 2, 4});
    one[6] = static_cast<std::uint8_t>(sum & 0xFFU);
    one[7] = static_cast<std::uint8_t>(sum >> 8U);
    bytes.insert(bytes.end(), one.begin(), one.end());
  }
  const Heard result = heard(bytes);
  CHECK(result.counts.frames == 10);
  CHECK(result.counts.over_range == 2);
  CHECK(result.counts.battery_low == 3);
}

TEST("many seeded faults cost at most the frames that they hit, and no false frame appears") {
  constexpr int frames = 5000;
  palpate::device::Seeded chance(11);
  const Bytes good = stream_of(frames);
  Bytes bytes;
  std::set<int> hit;
  for (std::size_t place = 0; place < good.size(); ++place) {
    const double draw = chance.uniform(0.0, 1.0);
    const int frame = static_cast<int>(place / 8);
    if (draw < 0.015) { hit.insert(frame); }
    if (draw < 0.005) { continue; }
    const bool changed = draw >= 0.005 && draw < 0.01;
    const auto change = static_cast<unsigned>(chance.uniform(1.0, 256.0));
    bytes.push_back(static_cast<std::uint8_t>(changed ? good[place] ^ change : good[place]));
    if (draw >= 0.01 && draw < 0.015) { bytes.push_back(good[place]); }
  }
  const Heard result = heard(bytes);
  const std::set<int> found(result.frames.begin(), result.frames.end());
  for (int n = 0; n < frames; ++n) { CHECK((found.contains(n) || hit.contains(n))); }
  // A frame that was not sent would have to pass a checksum of 16 bits by chance: some hundred
  // attempts of 2^-16 each.
  CHECK(std::ranges::is_sorted(result.frames));
  CHECK(found.size() == result.frames.size());
  CHECK(hit.size() > 400);
  CHECK(found.size() < static_cast<std::size_t>(frames));
}

TEST("arbitrary bytes do no harm") {
  palpate::device::Seeded chance(3);
  Bytes bytes(200000);
  for (std::uint8_t& byte : bytes) {
    const double draw = chance.uniform(0.0, 1.0);
    byte = draw < 0.2   ? std::uint8_t{0xA5}
           : draw < 0.4 ? std::uint8_t{0x5A}
                        : static_cast<std::uint8_t>(draw * 255.0);
  }
  const Heard result = heard(bytes);
  // Beginnings come about 200000 / 25 times, each of which passes with a chance of 2^-16.
  CHECK(result.counts.frames <= 5);
  CHECK(result.counts.bad_frames > 1000);
}

}  // namespace PALPATE_FILE
