// SPDX-License-Identifier: MIT
/// v' = v + h a(x, v); x' = x + h v  (Table 1).
#include "model/stepping/integrators/explicit_scheme.hpp"
#include "model/stepping/integrators/schemes.hpp"

namespace palpate {
namespace {

template <class Real>
class Euler final : public ExplicitScheme<Real> {
 public:
  void step(System<Real>& system, State<Real>& state, double t, double h) noexcept override {
    const Real dt = static_cast<Real>(h);
    system.acceleration(t, load_gate(t, h), state.position, state.velocity, this->a_);
    state.position += dt * state.velocity;
    state.velocity += dt * this->a_;
  }
};

}  // namespace

const IntegratorInfo schemes::euler{.name = "euler",
                                    .summary = "explicit Euler, Table 1",
                                    .one_evaluation = true,
                                    .make_double = make_scheme<Euler, double>,
                                    .make_float = make_scheme<Euler, float>};

}  // namespace palpate
