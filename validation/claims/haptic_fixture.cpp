// SPDX-License-Identifier: MIT

#include "validation/claims/haptic_fixture.hpp"

namespace palpate::haptics {

int extra_delay(const CaseContext& context) {
  return context.mutation != nullptr ? context.mutation->loop_delay : 0;
}

Rail::Rail(const Settings& settings) : settings_(settings) {}

device::DeviceSample Rail::exchange(const Eigen::Vector3d& force) noexcept {
  force_ = force.x();
  return {.position = {read(), 0.0, 0.0}};
}

double Rail::read() const {
  const double step = settings_.encoder_step;
  return step > 0.0 ? step * std::round(place_ / step) : place_;
}

/// The exact motion under a constant force for a while.
void Rail::glide(double force, double time) noexcept {
  const double tau = settings_.mass / settings_.viscosity;
  const double decay = -std::expm1(-time / tau);
  const double end_velocity = force / settings_.viscosity;
  place_ += end_velocity * time + (velocity_ - end_velocity) * tau * decay;
  velocity_ += (end_velocity - velocity_) * decay;
}

/// With friction a glide ends at zero velocity and starts only above the friction.
void Rail::advance() noexcept {
  const double friction = settings_.coulomb_friction;
  double left = settings_.period;
  for (int stretch = 0; stretch < 3 && left > 0.0; ++stretch) {
    if (friction == 0.0) { return glide(force_, left); }
    const bool rests = velocity_ == 0.0;
    if (rests && std::abs(force_) <= friction) { return; }
    const double against =
        rests ? std::copysign(friction, force_) : std::copysign(friction, velocity_);
    const double net = force_ - against;
    // v(t) = e + (v - e) exp(-t / tau) with e = net / b; it ends where that is zero.
    const double tau = settings_.mass / settings_.viscosity;
    const double end_velocity = net / settings_.viscosity;
    const bool stops = !rests && end_velocity * velocity_ < 0.0;
    const double stop = stops ? tau * std::log1p(-velocity_ / end_velocity) : left;
    const double time = std::min(left, stop);
    glide(net, time);
    if (stops && stop <= left) { velocity_ = 0.0; }
    left -= time;
  }
}

}  // namespace palpate::haptics
