// SPDX-License-Identifier: MIT

#include "device/falcon/emulator.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <istream>
#include <ostream>
#include <string>
#include <string_view>

namespace palpate::device::falcon {

Firmware::Firmware(const FirmwareOptions& options) noexcept
    : options_(options), state_(options.loaded ? FirmwareState::run : FirmwareState::boot) {}

void Firmware::receive(std::span<const std::uint8_t> bytes, double now_s,
                       const DevicePacket& present, FirmwareSink& sink) noexcept {
  pass_time(now_s, sink);
  for (const std::uint8_t byte : bytes) {
    byte_time_ = now_s;
    const std::int64_t bad_before = reader_.counts().bad_frames;
    const std::optional<HostPacket> request = reader_.take(byte);
    // In load '<' may be part of the image, so bad frames are not reported.
    if (state_ != FirmwareState::load && reader_.counts().bad_frames > bad_before) {
      note(FirmwareEvent::bad_frame, sink);
      stray_noted_ = true;  // the byte that ended it is part of it
    }
    if (request) {
      answer(*request, now_s, present, sink);
    } else {
      take(byte, sink);
    }
  }
}

void Firmware::take(std::uint8_t byte, FirmwareSink& sink) noexcept {
  if (state_ == FirmwareState::load ||
      (state_ == FirmwareState::ready && byte == load_request && reader_.pending_bytes() == 0)) {
    sink.send({&byte, 1});
    ++echoed_bytes_;
    const bool begins = state_ == FirmwareState::ready;
    state_ = FirmwareState::load;
    if (begins) { note(FirmwareEvent::load_begun, sink); }
    return;
  }
  const bool in_hail = state_ != FirmwareState::run && byte == hail_request[hail_matched_];
  hail_matched_ = in_hail ? hail_matched_ + 1 : (byte == hail_request[0] ? 1U : 0U);
  const bool expected =
      reader_.pending_bytes() > 0 || (state_ != FirmwareState::run && hail_matched_ > 0);
  if (!expected && !stray_noted_) { note(FirmwareEvent::stray_bytes, sink); }
  stray_noted_ = !expected;
  if (hail_matched_ < hail_request.size()) { return; }
  hail_matched_ = 0;
  state_ = FirmwareState::ready;
  note(FirmwareEvent::hail, sink);
  sink.send(hail_reply);
}

void Firmware::answer(const HostPacket& request, double now_s, const DevicePacket& present,
                      FirmwareSink& sink) noexcept {
  if (state_ != FirmwareState::run) {
    if (state_ != FirmwareState::load) { note(FirmwareEvent::skipped_load, sink); }
    state_ = FirmwareState::run;
    note(FirmwareEvent::run_begun, sink);
  }
  stray_noted_ = false;
  hail_matched_ = 0;
  last_ = request;
  asked_ = true;
  watchdog_noted_ = false;
  torque_end_ = now_s + options_.watchdog;
  ++replies_;
  sink.send(encode(present));
  sink.served(request, present);
}

void Firmware::pass_time(double now_s, FirmwareSink& sink) noexcept {
  if (asked_ && !watchdog_noted_ && !asked_lately(now_s)) {
    watchdog_noted_ = true;
    note(FirmwareEvent::watchdog, sink);
  }
  const bool loading = state_ == FirmwareState::ready || state_ == FirmwareState::load;
  if (loading && now_s - byte_time_ >= options_.load_silence) {
    state_ = FirmwareState::boot;
    reader_.give_up();
    hail_matched_ = 0;
    note(FirmwareEvent::load_abandoned, sink);
  }
}

void Firmware::begin_run(double now_s, FirmwareSink& sink) noexcept {
  pass_time(now_s, sink);
  if (state_ == FirmwareState::run) { return; }
  if (state_ != FirmwareState::load) { return note(FirmwareEvent::early_run, sink); }
  state_ = FirmwareState::run;
  reader_.give_up();  // bytes of the incomplete packet had the other baud rate
  note(FirmwareEvent::run_begun, sink);
}

void Firmware::lose_power(double now_s, FirmwareSink& sink) noexcept {
  pass_time(now_s, sink);
  state_ = FirmwareState::boot;
  reader_.give_up();
  hail_matched_ = 0;
  last_ = {};
  asked_ = false;
  note(FirmwareEvent::power_loss, sink);
}

bool Firmware::asked_lately(double now_s) const noexcept { return asked_ && now_s < torque_end_; }

std::array<std::int16_t, 3> Firmware::words(double now_s) const noexcept {
  return asked_lately(now_s) ? last_.words : std::array<std::int16_t, 3>{};
}

bool Firmware::homing(double now_s) const noexcept { return asked_lately(now_s) && last_.homing; }

void Firmware::note(FirmwareEvent event, FirmwareSink& sink) noexcept {
  ++events_[static_cast<std::size_t>(event)];
  sink.happened(event);
}

const char* name_of(FirmwareState state) noexcept {
  constexpr std::array names{"boot", "ready", "load", "run"};
  return names[static_cast<std::size_t>(state)];
}

const char* name_of(FirmwareEvent event) noexcept {
  constexpr std::array<const char*, firmware_event_count> names{
      "hail",      "load-begun", "run-begun", "skipped-load",   "stray-bytes",
      "bad-frame", "early-run",  "watchdog",  "load-abandoned", "power-loss"};
  return names[static_cast<std::size_t>(event)];
}

namespace {

constexpr double longest_idle = 5e-3;  // largest time between two calls [s]
constexpr std::size_t buffer_bytes = 512;
constexpr int most_reads = 16;  // limit per call, so that a flood of bytes does not delay the body

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

Emulator::Emulator(Body& body, const FirmwareOptions& options, const FaultScript& faults)
    : body_(body),
      firmware_(options),
      in_(faults, LinkFault::Direction::to_device),
      out_(faults, LinkFault::Direction::to_host),
      device_faults_(faults) {}

void Emulator::serve(ByteLink& link) noexcept {
  std::array<std::uint8_t, buffer_bytes> buffer;
  now_ = link.now();
  follow_baud(link);
  for (int n = 0; n < most_reads; ++n) {
    const std::size_t count = link.read(buffer);
    if (count == 0) { break; }
    in_.send({buffer.data(), count}, now_);
  }
  move_body(now_);
  receive_all(now_);
  deliver(link);
}

/// A host waits for the echo of its image, then changes the baud rate, then sends. Drivers also
/// change it before the upload, which means nothing.
void Emulator::follow_baud(const ByteLink& link) noexcept {
  const unsigned baud = link.baud();
  const bool changed = baud_ != 0 && baud != 0 && baud != baud_;
  baud_ = baud;
  if (changed && powered_ && firmware_.state() == FirmwareState::load) {
    firmware_.begin_run(now_, *this);
  }
}

void Emulator::move_body(double now_s) noexcept {
  for (; static_cast<double>(steps_ + 1) * body_step <= now_s; ++steps_) {
    const double time = static_cast<double>(steps_) * body_step;
    const bool powered = device_faults_.powered(time);
    if (powered_ && !powered) {
      firmware_.lose_power(time, *this);
      body_.lose_power();
    }
    powered_ = powered;
    if (device_faults_.begins_to_stick(time)) { device_faults_.hold(body_.present(), time); }
    body_.advance(body_step, firmware_.words(time), firmware_.homing(time));
  }
}

void Emulator::receive_all(double now_s) noexcept {
  std::array<std::uint8_t, buffer_bytes> buffer;
  if (powered_) { firmware_.receive({}, now_s, {}, *this); }  // time goes on
  std::size_t count = in_.receive(buffer, now_s);
  if (count == 0) { return; }
  DevicePacket present = body_.present();
  device_faults_.apply(present, now_s);
  for (; count > 0; count = in_.receive(buffer, now_s)) {
    if (powered_) { firmware_.receive({buffer.data(), count}, now_s, present, *this); }
  }
}

void Emulator::deliver(ByteLink& link) noexcept {
  std::array<std::uint8_t, buffer_bytes> buffer;
  for (std::size_t count = 0; (count = out_.receive(buffer, now_)) > 0;) {
    if (!link.write({buffer.data(), count})) { ++lost_writes_; }
  }
}

double Emulator::next_call(double now_s) const noexcept {
  double next = now_s + longest_idle;
  for (const FaultChannel* channel : {&in_, &out_}) {
    if (const auto arrival = channel->next_arrival()) { next = std::min(next, *arrival); }
  }
  return next;
}

void Emulator::send(std::span<const std::uint8_t> bytes) noexcept { out_.send(bytes, now_); }

void Emulator::served(const HostPacket& request, const DevicePacket& reply) noexcept {
  if (observer_ != nullptr) { observer_->served(now_, request, reply); }
}

void Emulator::happened(FirmwareEvent event) noexcept {
  if (observer_ != nullptr) { observer_->happened(now_, event); }
}

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
