// SPDX-License-Identifier: MIT
/// v' = v + h a(x, v); x' = x + h v'  (Table 1), also called semi-implicit Euler.
#include <cmath>

#include "model/stepping/integrators/explicit_scheme.hpp"
#include "model/stepping/integrators/schemes.hpp"

namespace palpate {
namespace {

template <class Real>
class EulerCromer final : public ExplicitScheme<Real> {
 public:
  void prepare(System<Real>& system, const State<Real>& state, double h) override {
    one_pass_ = system.has_one_pass();
    if (one_pass_) {
      system.prepare_one_pass();
    } else {
      ExplicitScheme<Real>::prepare(system, state, h);
    }
  }
  void step(System<Real>& system, State<Real>& state, double t, double h) noexcept override {
    const Real dt = static_cast<Real>(h);
    if (one_pass_) {
      travelled_ += h * std::sqrt(system.one_pass(t, load_gate(t, h), dt, state));
      return;
    }
    system.acceleration(t, load_gate(t, h), state.position, state.velocity, this->a_);
    state.velocity += dt * this->a_;
    state.position += dt * state.velocity;
  }
  [[nodiscard]] std::optional<double> most_travelled() const noexcept override {
    return one_pass_ ? std::optional(travelled_) : std::nullopt;
  }

 private:
  bool one_pass_ = false;
  double travelled_ = 0.0;  ///< [m]
};

}  // namespace

const IntegratorInfo schemes::euler_cromer{.name = "euler-cromer",
                                           .summary = "semi-implicit Euler, Table 1",
                                           .one_evaluation = true,
                                           .make_double = make_scheme<EulerCromer, double>,
                                           .make_float = make_scheme<EulerCromer, float>};

}  // namespace palpate
