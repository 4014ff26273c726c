// SPDX-License-Identifier: MIT
/// v' = v + h a(x, v); x' = x + h v'  (Table 1), also called semi-implicit Euler.
#include "model/stepping/integrators/explicit_scheme.hpp"
#include "model/stepping/integrators/schemes.hpp"

namespace palpate {
namespace {

template <class Real>
class EulerCromer final : public ExplicitScheme<Real> {
 public:
  void step(System<Real>& system, State<Real>& state, double t, double h) noexcept override {
    const Real dt = static_cast<Real>(h);
    system.acceleration(t, load_gate(t, h), state.position, state.velocity, this->a_);
    state.velocity += dt * this->a_;
    state.position += dt * state.velocity;
  }
};

}  // namespace

const IntegratorInfo schemes::euler_cromer{.name = "euler-cromer",
                                           .summary = "semi-implicit Euler, Table 1",
                                           .one_evaluation = true,
                                           .make_double = make_scheme<EulerCromer, double>,
                                           .make_float = make_scheme<EulerCromer, float>};

}  // namespace palpate
