// SPDX-License-Identifier: MIT
// Fuzz test of readers and firmware with arbitrary bytes in arbitrary segments. Built twice: with a
// main() that replays stored inputs, and for libFuzzer (PALPATE_FUZZ).

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "device/falcon/driver.hpp"
#include "device/pressure_link/frame.hpp"
#include "tests/device/falcon/samples.hpp"

namespace {

using namespace palpate::device::falcon;
using Bytes = std::span<const std::uint8_t>;

void must(bool holds, const char* what) {
  if (holds) { return; }
  std::fprintf(stderr, "broken: %s\n", what);
  std::abort();
}
#define MUST(condition) must(condition, #condition)

/// Finds well-formed requests by exhaustive search: 16 bytes that decode, at any position. A
/// packet contains '<' only at its start, so two packets never overlap.
template <class Packet> std::vector<Packet> packets_in(Bytes bytes) {
  std::vector<Packet> packets;
  for (std::size_t n = 0; n + packet_bytes <= bytes.size(); ++n) {
    PacketBytes candidate{};
    std::copy_n(bytes.begin() + static_cast<long>(n), packet_bytes, candidate.begin());
    if (const auto packet = decode<Packet>(candidate)) { packets.push_back(*packet); }
  }
  return packets;
}

template <class Packet> void fuzz_reader(Bytes bytes) {
  PacketReader<Packet> reader;
  std::vector<Packet> found;
  for (const std::uint8_t byte : bytes) {
    const auto packet = reader.take(byte);
    if (packet) { found.push_back(*packet); }
    MUST(reader.pending_bytes() < packet_bytes);
  }
  MUST(found == packets_in<Packet>(bytes));
  const ReaderCounts& counts = reader.counts();
  MUST(counts.frames == static_cast<std::int64_t>(found.size()));
  MUST(static_cast<std::int64_t>(bytes.size()) ==
       16 * counts.frames + counts.skipped_bytes +
           static_cast<std::int64_t>(reader.pending_bytes()));
  for (const Packet& packet : found) { MUST(decode<Packet>(encode(packet)) == packet); }
}

/// Reader of the pressure link: counts every byte once, and returns only frames that decode.
void fuzz_pressure_link(Bytes bytes) {
  namespace link = palpate::device::pressure_link;
  link::FrameReader reader;
  std::int64_t found = 0;
  for (const std::uint8_t byte : bytes) {
    if (const auto received = reader.take(byte)) {
      ++found;
      MUST(link::decode(link::encode(received->frame)) == received->frame);
      MUST(received->missing_before >= 0 && received->missing_before < 256);
    }
    MUST(reader.pending_bytes() < link::frame_bytes);
  }
  const link::ReaderCounts& counts = reader.counts();
  MUST(counts.frames == found);
  MUST(static_cast<std::int64_t>(bytes.size()) ==
       static_cast<std::int64_t>(link::frame_bytes) * (counts.frames + counts.repeated) +
           counts.skipped_bytes + static_cast<std::int64_t>(reader.pending_bytes()));
}

constexpr FirmwareOptions options{};

/// Feeds one segment of the input at time `now` [s], then checks the invariants.
void feed(Firmware& firmware, Bytes piece, double now, sample::Kept& kept) {
  const DevicePacket present{.counts = {-1, 2, 30000}, .homed = {true, false, true}};
  const std::size_t requests_before = kept.requests.size();
  const std::size_t sent_before = kept.sent.size();
  firmware.receive(piece, now, present, kept);
  const std::size_t requests = kept.requests.size() - requests_before;
  MUST(kept.sent.size() - sent_before <= 4 * (piece.size() + 1) + packet_bytes * requests);
  if (requests > 0) {
    MUST(firmware.words(now) == kept.requests.back().words);  // as received
    MUST(firmware.homing(now) == kept.requests.back().homing);
    MUST(firmware.state() == FirmwareState::run);
  }
  MUST((firmware.words(now + options.watchdog) == std::array<std::int16_t, 3>{}));
  MUST(!firmware.homing(now + options.watchdog));
}

/// Feeds the input in segments. The first byte of each encodes its length and the idle time before
/// it.
void fuzz_firmware(Bytes input) {
  Firmware firmware(options);
  sample::Kept kept;
  std::vector<std::uint8_t> stream;
  double now = 0.0;
  bool unbroken = true;  // no silence made the firmware forget half a packet
  while (!input.empty()) {
    const unsigned head = input.front();
    const std::size_t length = std::min<std::size_t>(head & 0x1FU, input.size() - 1);
    now += 1e-3 * static_cast<double>((head >> 5U) * (head >> 5U) * 30);
    const Bytes piece = input.subspan(1, length);
    stream.insert(stream.end(), piece.begin(), piece.end());
    feed(firmware, piece, now, kept);
    unbroken = unbroken && firmware.count(FirmwareEvent::load_abandoned) == 0;
    input = input.subspan(1 + length);
  }
  const std::vector<HostPacket> requests = packets_in<HostPacket>(stream);
  MUST(kept.requests.size() <= requests.size());
  if (unbroken) { MUST(kept.requests == requests); }
  MUST(firmware.replies() == static_cast<std::int64_t>(kept.requests.size()));
}

/// Same bytes on a link with faults, and a driver that reads the replies.
void fuzz_emulator(Bytes input) {
  const FaultScript faults{.seed = input.empty() ? 0U : input.front(),
                           .faults = {{.kind = LinkFault::Kind::drop, .probability = 0.02},
                                      {.kind = LinkFault::Kind::corrupt, .probability = 0.02},
                                      {.kind = LinkFault::Kind::duplicate, .probability = 0.02},
                                      {.kind = LinkFault::Kind::latency, .jitter = 2e-3}}};
  sample::SummingBody body;
  Emulator emulator(body, options, faults);
  MemoryLink cable(1e-3);
  cable.attach(emulator);
  Driver driver(cable.host(), {.reply_deadline = 2e-3});
  for (std::size_t n = 0; n < input.size(); n += 40) {
    (void)cable.host().write(input.subspan(n, std::min<std::size_t>(40, input.size() - n)));
    (void)driver.exchange({.words = {1, 1, 1}});
  }
  MUST(emulator.firmware().replies() == emulator.firmware().reader_counts().frames);
  cable.run_until(cable.now() + 0.05);
  MUST((emulator.firmware().words(cable.now()) == std::array<std::int16_t, 3>{}));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Bytes input(data, size);
  fuzz_reader<HostPacket>(input);
  fuzz_reader<DevicePacket>(input);
  fuzz_pressure_link(input);
  fuzz_firmware(input);
  if (size <= 2048) { fuzz_emulator(input); }
  return 0;
}

#ifndef PALPATE_LIBFUZZER
int main(int argc, char** argv) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(argc > 1 ? argv[1] : ".")) {
    std::ifstream file(entry.path(), std::ios::binary);
    const std::vector<char> text{std::istreambuf_iterator<char>(file), {}};
    const std::vector<std::uint8_t> bytes(text.begin(), text.end());
    std::printf("%s\n", entry.path().filename().c_str());
    std::fflush(stdout);  // the last name is the one that broke
    (void)LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
    ++count;
  }
  std::printf("%d inputs\n", count);
  return count > 0 ? 0 : 1;
}
#endif
