// SPDX-License-Identifier: MIT
#include "device/falcon/memory_link.hpp"

#include <algorithm>

namespace palpate::device::falcon {

void MemoryLink::serve() noexcept {
  if (served_ == nullptr || serving_) { return; }
  serving_ = true;
  served_->serve(device_);
  serving_ = false;
}

void MemoryLink::run_until(double time_s) noexcept {
  serve();
  while (now_ < time_s) {
    now_ = std::min(now_ + step_, time_s);
    serve();
  }
}

std::size_t MemoryLink::End::read(std::span<std::uint8_t> into) noexcept {
  const std::size_t count = std::min(into.size(), in_.size());
  for (std::uint8_t& byte : into.first(count)) {
    byte = in_.front();
    in_.pop();
  }
  return count;
}

bool MemoryLink::End::wait_until(double deadline_s) noexcept {
  cable_.serve();
  while (in_.empty() && cable_.now_ < deadline_s) {
    cable_.run_until(std::min(cable_.now_ + cable_.step_, deadline_s));
  }
  return !in_.empty();
}

bool MemoryLink::End::write(std::span<const std::uint8_t> bytes) noexcept {
  return std::ranges::all_of(bytes, [&](std::uint8_t byte) { return out_.push(byte); });
}

}  // namespace palpate::device::falcon
