// SPDX-License-Identifier: MIT
#pragma once
/// A haptic loop's tick: read the place, ask for the force, send it. Time is the caller's.

#include <Eigen/Core>
#include <cstddef>
#include <utility>
#include <vector>

#include "device/haptic_device.hpp"

namespace palpate::device {

/// A force holds from the exchange that carried it to the next one. Without delay a tick takes two
/// exchanges, one that reads and one that writes; a delay of one tick is that of a loop with a
/// single exchange, whose request carries what followed from the reply before; longer ones add to
/// it.
class ServoLoop {
 public:
  /// `delay` in ticks; the device outlives the loop.
  ServoLoop(HapticDevice& device, int delay)
      : device_(device), waiting_(static_cast<std::size_t>(delay), Eigen::Vector3d::Zero()) {}

  /// `render(sample)` gives the force on the hand [N], frame of the device.
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

  /// What the device was asked for last [N]; holds until the next tick.
  [[nodiscard]] const Eigen::Vector3d& sent() const { return sent_; }

 private:
  HapticDevice& device_;
  std::vector<Eigen::Vector3d> waiting_;  ///< computed, not yet sent
  std::size_t oldest_ = 0;
  Eigen::Vector3d sent_{0.0, 0.0, 0.0};
};

// Does a rendered environment give more energy than it took? Observer and controller in the time
// domain (Hannaford & Ryu, IEEE Transactions on Robotics and Automation 18, 2002).

/// Energy that the hand has put into the environment behind a port whose force is held between
/// samples: the sum of -F_k.(x_{k+1} - x_k), which is exact for held forces. Below zero the
/// environment is active: it has given more than it took.
class PassivityObserver {
 public:
  /// The grip is at `place` [m], after `force` [N] on the hand was held since the last sample,
  /// `time` [s] being that of this one.
  void observe(double time, const Eigen::Vector3d& place, const Eigen::Vector3d& force) noexcept {
    if (begun_) { energy_ -= force.dot(place - place_); }
    begun_ = true;
    place_ = place;
    if (energy_ < least_) {
      least_ = energy_;
      least_at_ = time;
    }
  }

  [[nodiscard]] double energy() const { return energy_; }      ///< [J]
  [[nodiscard]] double least() const { return least_; }        ///< never above 0 [J]
  [[nodiscard]] double least_at() const { return least_at_; }  ///< [s]
  [[nodiscard]] const Eigen::Vector3d& place() const { return place_; }

 private:
  bool begun_ = false;
  Eigen::Vector3d place_{0.0, 0.0, 0.0};
  double energy_ = 0.0;
  double least_ = 0.0;
  double least_at_ = 0.0;
};

/// Adds the damping that takes a shortage of energy back within one tick, and no more than a held
/// force can damp without feeding energy in itself.
class PassivityController {
 public:
  /// `most_viscosity` [N s/m]: half the effective mass of hand and device over the period keeps the
  /// added damping itself stable.
  PassivityController(double period, double most_viscosity)
      : period_(period), most_viscosity_(most_viscosity) {}

  /// The force to send instead of `force` [N] where the observer stands at `energy` [J] and the
  /// grip moves with `velocity` [m/s].
  [[nodiscard]] Eigen::Vector3d limit(double energy, const Eigen::Vector3d& velocity,
                                      const Eigen::Vector3d& force) noexcept;

  [[nodiscard]] double taken() const { return taken_; }  ///< by the added damping so far [J]

 private:
  double period_;
  double most_viscosity_;
  double taken_ = 0.0;
};

}  // namespace palpate::device
