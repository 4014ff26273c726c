// SPDX-License-Identifier: MIT
#include "device/falcon/emulator.hpp"

#include <algorithm>

namespace palpate::device::falcon {
namespace {

constexpr double longest_idle = 5e-3;  // [s] between two calls, so that the body keeps up
constexpr std::size_t buffer_bytes = 512;
constexpr int most_reads = 16;  // of one call: a flood must not hold up the body

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
  for (int n = 0; n < most_reads; ++n) {
    const std::size_t count = link.read(buffer);
    if (count == 0) { break; }
    in_.send({buffer.data(), count}, now_);
  }
  move_body(now_);
  receive_all(now_);
  deliver(link);
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

}  // namespace palpate::device::falcon
