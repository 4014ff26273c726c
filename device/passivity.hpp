// SPDX-License-Identifier: MIT
#pragma once
/// Does a rendered environment give more energy than it took? Observer and controller in the time
/// domain (Hannaford & Ryu, IEEE Transactions on Robotics and Automation 18, 2002).

#include <Eigen/Core>

namespace palpate::device {

/// Energy that the hand has put into the environment behind a port whose force is held between
/// samples: the sum of -F_k.(x_{k+1} - x_k), which is exact for held forces. Below zero the
/// environment is active: it has given more than it took.
class PassivityObserver {
 public:
  /// The grip is at `place` [m], after `force` [N] on the hand was held since the last sample, `time`
  /// [s] being that of this one.
  void observe(double time, const Eigen::Vector3d& place, const Eigen::Vector3d& force) noexcept {
    if (begun_) { energy_ -= force.dot(place - place_); }
    begun_ = true;
    place_ = place;
    if (energy_ < least_) {
      least_ = energy_;
      least_at_ = time;
    }
  }

  [[nodiscard]] double energy() const { return energy_; }    ///< [J]
  [[nodiscard]] double least() const { return least_; }      ///< never above 0 [J]
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

  /// The force to send instead of `force` [N] where the observer stands at `energy` [J] and the grip
  /// moves with `velocity` [m/s].
  [[nodiscard]] Eigen::Vector3d limit(double energy, const Eigen::Vector3d& velocity,
                                      const Eigen::Vector3d& force) noexcept;

  [[nodiscard]] double taken() const { return taken_; }  ///< by the added damping so far [J]

 private:
  double period_;
  double most_viscosity_;
  double taken_ = 0.0;
};

}  // namespace palpate::device
