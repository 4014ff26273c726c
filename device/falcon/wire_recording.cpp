// SPDX-License-Identifier: MIT

#include "device/falcon/wire_recording.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <istream>
#include <ostream>
#include <string>
#include <string_view>

namespace palpate::device::falcon {
namespace {

constexpr std::string_view header = "time_s,direction,bytes";
constexpr std::string_view to_device = "to-device";
constexpr std::string_view to_host = "to-host";
constexpr std::string_view digits = "0123456789abcdef";

[[noreturn]] void refuse(int line, const std::string& text) {
  throw RecordingError("line " + std::to_string(line) + ": " + text);
}

std::string hex(const PacketBytes& bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += digits[byte >> 4U];
    text += digits[byte & 0x0FU];
  }
  return text;
}

bool parse_hex(std::string_view text, PacketBytes& bytes) {
  if (text.size() != 2 * packet_bytes) { return false; }
  for (std::size_t n = 0; n < packet_bytes; ++n) {
    const char* begin = text.data() + 2 * n;
    const auto [end, error] = std::from_chars(begin, begin + 2, bytes[n], 16);
    if (error != std::errc{} || end != begin + 2) { return false; }
  }
  return true;
}

bool parse_time(std::string_view text, double& time) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), time);
  return error == std::errc{} && end == text.data() + text.size() && std::isfinite(time);
}

WireRecord parse(std::string_view text, int line) {
  const std::size_t first = std::min(text.find(','), text.size());
  const std::size_t second = std::min(text.find(',', first + 1), text.size());
  const std::string_view direction =
      second > first ? text.substr(first + 1, second - first - 1) : std::string_view{};
  WireRecord record;
  if (!parse_time(text.substr(0, first), record.time)) { refuse(line, "time_s; a finite number"); }
  if (direction != to_device && direction != to_host) {
    refuse(line, "direction; must be to-device or to-host");
  }
  record.direction =
      direction == to_device ? WireRecord::Direction::to_device : WireRecord::Direction::to_host;
  const bool whole = second < text.size() && parse_hex(text.substr(second + 1), record.bytes) &&
                     (record.direction == WireRecord::Direction::to_device
                          ? decode<HostPacket>(record.bytes).has_value()
                          : decode<DevicePacket>(record.bytes).has_value());
  if (!whole) { refuse(line, "bytes; must be the 32 hexadecimal digits of a well-formed packet"); }
  return record;
}

/// Observer that collects the immediate replies of an emulator to one request.
class ReplyCatcher final : public EmulatorObserver {
 public:
  void served(double, const HostPacket&, const DevicePacket& reply) noexcept override {
    bytes = encode(reply);
    ++count;
  }
  PacketBytes bytes{};
  int count = 0;
};

}  // namespace

void WireRecording::served(double time_s, const HostPacket& request,
                           const DevicePacket& reply) noexcept {
  add({.time = time_s, .direction = WireRecord::Direction::to_device, .bytes = encode(request)});
  add({.time = time_s, .direction = WireRecord::Direction::to_host, .bytes = encode(reply)});
}

void WireRecording::add(const WireRecord& record) noexcept {
  if (records_.size() == records_.capacity()) {
    ++left_out_;
  } else {
    records_.push_back(record);
  }
}

ReplayResult replay(const WireRecording& recording, Emulator& emulator) {
  ReplayResult result;
  ReplyCatcher caught;
  MemoryLink cable;
  cable.attach(emulator);
  emulator.observe(&caught);
  for (const WireRecord& record : recording.records()) {
    if (record.direction == WireRecord::Direction::to_device) {
      cable.run_until(record.time);
      caught.count = 0;
      (void)cable.host().write(record.bytes);
      cable.run_until(record.time);
      ++result.requests;
    } else if (caught.count != 1 || caught.bytes != record.bytes) {
      ++result.different_replies;
    }
  }
  emulator.observe(nullptr);
  return result;
}

void write_csv(std::ostream& out, const WireRecording& recording) {
  out << header << '\n';
  for (const WireRecord& record : recording.records()) {
    std::array<char, 32> time{};
    const char* end = std::to_chars(time.data(), time.data() + time.size(), record.time).ptr;
    out << std::string_view(time.data(), static_cast<std::size_t>(end - time.data())) << ','
        << (record.direction == WireRecord::Direction::to_device ? to_device : to_host) << ','
        << hex(record.bytes) << '\n';
  }
}

WireRecording read_csv(std::istream& in) {
  std::vector<WireRecord> records;
  std::string text;
  int line = 1;
  if (!std::getline(in, text) || text != header) {
    refuse(line, "header; must be " + std::string(header));
  }
  while (std::getline(in, text)) {
    const WireRecord record = parse(text, ++line);
    const bool backwards = !records.empty() && record.time < records.back().time;
    if (backwards) { refuse(line, "time_s goes back; must not fall"); }
    records.push_back(record);
  }
  return WireRecording(std::move(records));
}

}  // namespace palpate::device::falcon
