// SPDX-License-Identifier: MIT
#pragma once
/// A haptic loop's tick: read the place, ask for the force, send it. Time is the caller's.

#include <cstddef>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "device/haptic_device.hpp"

namespace palpate::device {

/// A force holds from the exchange that carried it to the next one. Without delay a tick takes two
/// exchanges, one that reads and one that writes; a delay of one tick is that of a loop with a single
/// exchange, whose request carries what followed from the reply before; longer ones add to it.
class ServoLoop {
 public:
  /// `delay` in ticks; the device outlives the loop.
  ServoLoop(HapticDevice& device, int delay)
      : device_(device),
        waiting_(static_cast<std::size_t>(delay), Eigen::Vector3d::Zero()) {}

  /// `render(sample)` gives the force on the hand [N], frame of the device.
  template <class Render>
  DeviceSample tick(Render&& render) noexcept {
    if (waiting_.empty()) {
      const DeviceSample sample = device_.exchange(sent_);
      sent_ = render(sample);
      device_.exchange(sent_);
      return sample;
    }
    sent_ = waiting_[oldest_];
    const DeviceSample sample = device_.exchange(sent_);
    waiting_[oldest_] = render(sample);
    oldest_ = (oldest_ + 1) % waiting_.size();
    return sample;
  }

  /// What the device was asked for last [N]; holds until the next tick.
  [[nodiscard]] const Eigen::Vector3d& sent() const { return sent_; }

 private:
  HapticDevice& device_;
  std::vector<Eigen::Vector3d> waiting_;  ///< computed, not yet sent
  std::size_t oldest_ = 0;
  Eigen::Vector3d sent_{0.0, 0.0, 0.0};
};

}  // namespace palpate::device
