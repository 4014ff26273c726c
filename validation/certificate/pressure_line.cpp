// SPDX-License-Identifier: MIT
#include "validation/certificate/pressure_line.hpp"

#include "validation/link_recording.hpp"

namespace palpate::certificate {

void PressureLine::send(double time, double pressure) noexcept {
  namespace link = device::pressure_link;
  while (static_cast<double>(frames_) / link::frames_per_second <= time) {
    if (const auto frame = frame_of(pressure, static_cast<std::size_t>(frames_))) {
      link::FrameBytes bytes = link::encode(*frame);
      if (damaged_ && frames_ % 2 == 1) { bytes[4] ^= 0xFFU; }
      for (const std::uint8_t byte : bytes) { (void)reader_.take(byte); }
    }
    ++frames_;
  }
}

}  // namespace palpate::certificate
