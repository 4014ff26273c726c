// SPDX-License-Identifier: MIT

#include "device/falcon/link_faults.hpp"

#include <algorithm>

namespace palpate::device::falcon {
namespace {

using Kind = LinkFault::Kind;
using Direction = LinkFault::Direction;

constexpr std::uint64_t stream_stride = 0x9E3779B97F4A7C15U;  // seeds of streams far apart

bool active(const LinkFault& fault, double now_s) noexcept {
  return now_s >= fault.start && now_s < fault.end;
}

bool of_link(Kind kind) noexcept {
  return kind == Kind::latency || kind == Kind::drop || kind == Kind::duplicate ||
         kind == Kind::corrupt || kind == Kind::unplug;
}

Seeded stream(const FaultScript& script, std::uint64_t number) {
  return Seeded(script.seed + number * stream_stride);
}

/// Returns the faults that occur. The probability of windows is drawn here, in the order of the
/// script, so that both directions and the device agree.
std::vector<LinkFault> drawn(const FaultScript& script) {
  std::vector<LinkFault> result;
  Seeded random = stream(script, 0);
  for (LinkFault fault : script.faults) {
    const double number = random.uniform();
    const bool window = fault.kind == Kind::unplug || !of_link(fault.kind);
    if (window && number >= fault.probability) { continue; }
    if (window) { fault.probability = 1.0; }
    result.push_back(fault);
  }
  return result;
}

}  // namespace

FaultChannel::FaultChannel(const FaultScript& script, Direction direction)
    : faults_(drawn(script)),
      for_writes_(stream(script, direction == Direction::to_device ? 1 : 2)),
      for_bytes_(stream(script, direction == Direction::to_device ? 3 : 4)) {
  std::erase_if(faults_, [&](const LinkFault& fault) {
    return !of_link(fault.kind) ||
           (fault.direction != Direction::both && fault.direction != direction);
  });
  runs_.resize(faults_.size(), 0);
}

/// Returns the delay of a whole write [s]. Every fault draws its two numbers in any case, so that
/// the window of one fault does not change the random sequence of another.
double FaultChannel::delay(double now_s) noexcept {
  double total = 0.0;
  bool late = false;
  for (const LinkFault& fault : faults_) {
    if (fault.kind != Kind::latency) { continue; }
    const double chance = for_writes_.uniform();
    const double share = for_writes_.uniform();
    if (!active(fault, now_s) || chance >= fault.probability) { continue; }
    total += fault.latency + share * fault.jitter;
    late = true;
  }
  if (late) { ++counts_.delayed_writes; }
  return total;
}

bool FaultChannel::hit(Kind kind, double now_s, Seeded& random) noexcept {
  bool any = false;
  for (std::size_t n = 0; n < faults_.size(); ++n) {
    const LinkFault& fault = faults_[n];
    if (fault.kind != kind) { continue; }
    const double chance = random.uniform();
    if (active(fault, now_s) && chance < fault.probability) { runs_[n] = fault.run; }
    if (runs_[n] == 0) { continue; }
    --runs_[n];
    any = true;
  }
  return any;
}

void FaultChannel::put(std::uint8_t byte, double arrival) noexcept {
  if (!under_way_.push({byte, arrival})) { ++counts_.overflowed; }
}

void FaultChannel::send(std::span<const std::uint8_t> bytes, double now_s) noexcept {
  const double arrival = now_s + delay(now_s);  // or later, because bytes stay in order
  for (std::uint8_t byte : bytes) {
    ++counts_.bytes;
    const bool dropped = hit(Kind::drop, now_s, for_bytes_);
    const bool doubled = hit(Kind::duplicate, now_s, for_bytes_);
    const bool corrupted = hit(Kind::corrupt, now_s, for_bytes_);
    constexpr unsigned other_values = 255;  // the added value is never 0, so the byte changes
    const auto change = static_cast<unsigned>(for_bytes_.uniform() * other_values) + 1;
    const bool unplugged = hit(Kind::unplug, now_s, for_bytes_);
    if (unplugged || dropped) {
      ++(unplugged ? counts_.unplugged : counts_.dropped);
      continue;
    }
    if (corrupted) {
      byte = static_cast<std::uint8_t>(byte + change);
      ++counts_.corrupted;
    }
    put(byte, arrival);
    if (doubled) {
      put(byte, arrival);
      ++counts_.duplicated;
    }
  }
}

std::size_t FaultChannel::receive(std::span<std::uint8_t> into, double now_s) noexcept {
  std::size_t count = 0;
  while (count < into.size() && under_way_.read_available() > 0 &&
         under_way_.front().arrival <= now_s) {
    into[count++] = under_way_.front().byte;
    under_way_.pop();
  }
  return count;
}

std::optional<double> FaultChannel::next_arrival() const noexcept {
  if (under_way_.read_available() == 0) { return std::nullopt; }
  return under_way_.front().arrival;
}

DeviceFaults::DeviceFaults(const FaultScript& script) {
  for (const LinkFault& fault : drawn(script)) {
    if (fault.kind == Kind::power_loss) { outages_.push_back(fault); }
    if (fault.kind == Kind::stuck_encoder || fault.kind == Kind::stuck_button) {
      stuck_.push_back({.fault = fault});
    }
  }
}

bool DeviceFaults::powered(double now_s) const noexcept {
  return std::ranges::none_of(outages_, [&](const LinkFault& f) { return active(f, now_s); });
}

bool DeviceFaults::begins_to_stick(double now_s) const noexcept {
  return std::ranges::any_of(stuck_, [&](const Stuck& stuck) {
    return stuck.fault.kind == Kind::stuck_encoder && !stuck.count && active(stuck.fault, now_s);
  });
}

void DeviceFaults::hold(const DevicePacket& present, double now_s) noexcept {
  for (Stuck& stuck : stuck_) {
    if (stuck.count || !active(stuck.fault, now_s)) { continue; }
    stuck.count = present.counts[static_cast<std::size_t>(stuck.fault.leg - 1)];
  }
}

void DeviceFaults::apply(DevicePacket& packet, double now_s) const noexcept {
  for (const Stuck& stuck : stuck_) {
    if (!active(stuck.fault, now_s)) { continue; }
    if (stuck.fault.kind == Kind::stuck_button) {
      packet.buttons = packet.buttons | stuck.fault.buttons;
    } else if (stuck.count) {
      packet.counts[static_cast<std::size_t>(stuck.fault.leg - 1)] = *stuck.count;
    }
  }
}

}  // namespace palpate::device::falcon
