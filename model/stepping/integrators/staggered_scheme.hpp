// SPDX-License-Identifier: MIT
#pragma once
/// Schemes that carry the velocity of half a step on: v(h/2) to begin with, then drift and kick.

#include "model/stepping/integrator.hpp"

namespace palpate {

template <class Real>
class StaggeredScheme : public Integrator<Real> {
 public:
  void prepare(System<Real>& system, const State<Real>& /*state*/, double /*h*/) override {
    f_.setZero(system.dof());
    previous_.setZero(system.dof());
    mean_.setZero(system.dof());
  }
  void start(System<Real>& system, State<Real>& state, double t, double h) noexcept override {
    const Real half = static_cast<Real>(0.5 * h);
    system.acceleration(t, load_gate(t, h), state.position, state.velocity, f_);
    previous_ = state.velocity - half * f_;
    state.velocity += half * f_;
  }
  /// Mean of the velocities half a step before and after: second order.
  const Vector<Real>& velocity_at(const State<Real>& state) noexcept override {
    mean_ = Real(0.5) * (previous_ + state.velocity);
    return mean_;
  }

  [[nodiscard]] std::size_t memory_bytes() const noexcept override { return bytes_of(f_, previous_, mean_); }

 protected:
  /// f_ at t + h, the end of the step from t: half the kick belongs to that step and half to the
  /// next, so each step's own loads act on its half.
  void straddling_force(System<Real>& system, const State<Real>& state, double t,
                        double h) noexcept {
    const double next = load_gate(t + h, h);
    system.force(t + h, next, state.position, state.velocity, f_);
    system.add_loads(t + h, next, Real(-0.5), f_);
    system.add_loads(t + h, load_gate(t, h), Real(0.5), f_);
  }

  Vector<Real> f_;         ///< [N]
  Vector<Real> previous_;  ///< velocity half a step ago [m/s]

 private:
  Vector<Real> mean_;
};

}  // namespace palpate
