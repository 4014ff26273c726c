// SPDX-License-Identifier: MIT
/// x' = x + h v + h^2/2 a;  a' = a(x', v + h a);  v' = v + h/2 (a + a').
#include "model/stepping/integrators/explicit_scheme.hpp"
#include "model/stepping/integrators/schemes.hpp"

namespace palpate {
namespace {

template <class Real>
class VelocityVerlet final : public ExplicitScheme<Real> {
 public:
  void prepare(System<Real>& system, const State<Real>& state, double h) override {
    ExplicitScheme<Real>::prepare(system, state, h);
    predicted_.setZero(system.dof());
    a_end_.setZero(system.dof());
  }
  void step(System<Real>& system, State<Real>& state, double t, double h) noexcept override {
    // a(t) is evaluated anew: the loads and the predicted velocity of the last step's end differ.
    const Real dt = static_cast<Real>(h);
    const double gate = load_gate(t, h);
    auto& a = this->a_;
    system.acceleration(t, gate, state.position, state.velocity, a);
    state.position += dt * state.velocity + (dt * dt / 2) * a;
    predicted_ = state.velocity + dt * a;
    system.acceleration(t + h, gate, state.position, predicted_, a_end_);
    state.velocity += (dt / 2) * (a + a_end_);
  }
  [[nodiscard]] std::size_t memory_bytes() const noexcept override { return bytes_of(this->a_, predicted_, a_end_); }

 private:
  Vector<Real> predicted_;
  Vector<Real> a_end_;
};

}  // namespace

const IntegratorInfo schemes::velocity_verlet{.name = "velocity-verlet",
                                              .summary = "velocity Verlet, predicted damping",
                                              .order_undamped = 2,
                                              .order_damped = 2,
                                              .evaluations = 2,
                                              .make_double = make_scheme<VelocityVerlet, double>,
                                              .make_float = make_scheme<VelocityVerlet, float>};

}  // namespace palpate
