// SPDX-License-Identifier: MIT
/// The classical Runge-Kutta method of order four on (x, v).
#include "model/stepping/integrators/explicit_scheme.hpp"
#include "model/stepping/integrators/schemes.hpp"

namespace palpate {
namespace {

template <class Real>
class RungeKutta4 final : public ExplicitScheme<Real> {
 public:
  void prepare(System<Real>& system, const State<Real>& state, double h) override {
    ExplicitScheme<Real>::prepare(system, state, h);
    for (Vector<Real>* work : {&q_, &v_, &dq_, &dv_}) { work->setZero(system.dof()); }
  }
  void step(System<Real>& system, State<Real>& state, double t, double h) noexcept override {
    const Real dt = static_cast<Real>(h);
    const double gate = load_gate(t, h);
    auto& a = this->a_;
    system.acceleration(t, gate, state.position, state.velocity, a);
    dq_ = state.velocity;
    dv_ = a;
    q_ = state.position + (dt / 2) * state.velocity;
    v_ = state.velocity + (dt / 2) * a;
    system.acceleration(t + h / 2, gate, q_, v_, a);
    dq_ += 2 * v_;
    dv_ += 2 * a;
    q_ = state.position + (dt / 2) * v_;
    v_ = state.velocity + (dt / 2) * a;
    system.acceleration(t + h / 2, gate, q_, v_, a);
    dq_ += 2 * v_;
    dv_ += 2 * a;
    q_ = state.position + dt * v_;
    v_ = state.velocity + dt * a;
    system.acceleration(t + h, gate, q_, v_, a);
    state.position += (dt / 6) * (dq_ + v_);
    state.velocity += (dt / 6) * (dv_ + a);
  }
  [[nodiscard]] std::size_t memory_bytes() const noexcept override { return bytes_of(this->a_, q_, v_, dq_, dv_); }

 private:
  Vector<Real> q_;
  Vector<Real> v_;
  Vector<Real> dq_;  ///< weighted sum of the stage velocities
  Vector<Real> dv_;  ///< weighted sum of the stage accelerations
};

}  // namespace

const IntegratorInfo schemes::rk4{.name = "rk4",
                                  .summary = "classical Runge-Kutta",
                                  .order_undamped = 4,
                                  .order_damped = 4,
                                  .evaluations = 4,
                                  .make_double = make_scheme<RungeKutta4, double>,
                                  .make_float = make_scheme<RungeKutta4, float>};

}  // namespace palpate
