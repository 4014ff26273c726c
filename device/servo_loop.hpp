// SPDX-License-Identifier: MIT
#pragma once
/// Tick of a haptic loop (read the position, compute the force, send it), and the passivity
/// observer and controller at the port of the device. The caller schedules the ticks.

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "device/haptic_device.hpp"

namespace palpate::device {

/// Servo loop with a delay of whole ticks. A force is held from the exchange that sends it to the
/// next exchange. Without delay a tick has two exchanges, one to read and one to write. With a
/// delay of one tick it has a single exchange, whose request carries the force for the previous
/// reply; longer delays add whole ticks.
class ServoLoop {
 public:
  /// `delay` is in ticks. The device must outlive the loop.
  ServoLoop(HapticDevice& device, int delay)
      : device_(device), waiting_(static_cast<std::size_t>(delay), Eigen::Vector3d::Zero()) {}

  /// Executes one tick. `render(sample)` returns the force on the hand [N] in the frame of the
  /// device.
  template <class Render> DeviceSample tick(Render&& render) noexcept {
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

  /// The last force sent to the device [N]; held until the next tick.
  [[nodiscard]] const Eigen::Vector3d& sent() const { return sent_; }

 private:
  HapticDevice& device_;
  std::vector<Eigen::Vector3d> waiting_;  ///< computed, not yet sent
  std::size_t oldest_ = 0;
  Eigen::Vector3d sent_{0.0, 0.0, 0.0};
};

// Passivity observer and controller in the time domain (Hannaford & Ryu, IEEE Transactions on
// Robotics and Automation 18, 2002).

/// Observer of the energy that the hand has put into the environment behind a port with held
/// forces: the sum of -F_k.(x_{k+1} - x_k), which is exact. A negative value means that the
/// environment is active.
class PassivityObserver {
 public:
  /// Adds a sample at `time` [s]: the grip is at `place` [m], and `force` [N] on the hand was held
  /// since the previous sample.
  void observe(double time, const Eigen::Vector3d& place, const Eigen::Vector3d& force) noexcept {
    if (begun_) { energy_ -= force.dot(place - place_); }
    begun_ = true;
    place_ = place;
    if (energy_ < least_) {
      least_ = energy_;
      least_at_ = time;
    }
  }

  [[nodiscard]] double energy() const { return energy_; }  ///< [J]
  [[nodiscard]] double least() const { return least_; }    ///< lowest energy so far, at most 0 [J]
  [[nodiscard]] double least_at() const { return least_at_; }  ///< time of the lowest energy [s]
  [[nodiscard]] const Eigen::Vector3d& place() const { return place_; }

 private:
  bool begun_ = false;
  Eigen::Vector3d place_{0.0, 0.0, 0.0};
  double energy_ = 0.0;
  double least_ = 0.0;
  double least_at_ = 0.0;
};

/// Controller that adds damping to dissipate an energy excess within one tick. The damping is
/// limited to the value that a held force can provide without adding energy.
class PassivityController {
 public:
  /// `most_viscosity` is the largest added damping [N s/m]. Half the effective mass of hand and
  /// device divided by the period keeps it stable.
  PassivityController(double period, double most_viscosity)
      : period_(period), most_viscosity_(most_viscosity) {}

  /// Returns the force to send instead of `force` [N] for an observed `energy` [J] and a grip
  /// velocity `velocity` [m/s].
  [[nodiscard]] Eigen::Vector3d limit(double energy, const Eigen::Vector3d& velocity,
                                      const Eigen::Vector3d& force) noexcept {
    const double speed_squared = velocity.squaredNorm();
    if (energy >= 0.0 || speed_squared == 0.0) { return force; }
    const double viscosity = std::min(-energy / (period_ * speed_squared), most_viscosity_);
    taken_ += viscosity * speed_squared * period_;
    return force - viscosity * velocity;
  }

  [[nodiscard]] double taken() const { return taken_; }  ///< energy dissipated so far [J]

 private:
  double period_;
  double most_viscosity_;
  double taken_ = 0.0;
};

}  // namespace palpate::device
