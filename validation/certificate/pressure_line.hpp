// SPDX-License-Identifier: MIT
#pragma once
/// The pressure link as part of a tick: a frame when one is due, coded, sent and read again.

#include "device/pressure_link/frame_reader.hpp"

namespace palpate::certificate {

class PressureLine {
 public:
  /// With `damaged` a byte of every other frame is changed on its way, so that the reader has to look for the
  /// next one.
  explicit PressureLine(bool damaged = false) : damaged_(damaged) {}

  /// The pressure [Pa] at this time [s]; sends nothing while no frame is due.
  void send(double time, double pressure) noexcept;
  [[nodiscard]] const device::pressure_link::ReaderCounts& counts() const { return reader_.counts(); }

 private:
  bool damaged_;
  long frames_ = 0;
  device::pressure_link::FrameReader reader_{};
};

}  // namespace palpate::certificate
