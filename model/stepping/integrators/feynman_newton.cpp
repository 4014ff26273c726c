// SPDX-License-Identifier: MIT
/// x' = x + h v; v' = v + h a(x', v). With v taken at t = h/2 to begin with it is Feynman's
/// half-step method; as the paper prints it, v is the one of t = 0, and the order falls to one.
#include "model/stepping/integrators/explicit_scheme.hpp"
#include "model/stepping/integrators/schemes.hpp"
#include "model/stepping/integrators/staggered_scheme.hpp"

namespace palpate {
namespace {

template <class Real>
class FeynmanNewtonPrinted final : public ExplicitScheme<Real> {
 public:
  void step(System<Real>& system, State<Real>& state, double t, double h) noexcept override {
    const Real dt = static_cast<Real>(h);
    state.position += dt * state.velocity;
    system.acceleration(t + h, load_gate(t, h), state.position, state.velocity, this->a_);
    state.velocity += dt * this->a_;
  }
};

template <class Real>
class FeynmanNewton final : public StaggeredScheme<Real> {
 public:
  void step(System<Real>& system, State<Real>& state, double t, double h) noexcept override {
    const Real dt = static_cast<Real>(h);
    this->previous_ = state.velocity;
    state.position += dt * state.velocity;
    this->straddling_force(system, state, t, h);
    state.velocity += dt * system.inverse_mass().cwiseProduct(this->f_);
  }
};

}  // namespace

const IntegratorInfo schemes::feynman_newton_printed{
    .name = "feynman-newton-printed",
    .summary = "Feynman-Newton as printed in Table 1: starts from v(0)",
    .one_evaluation = true,
    .make_double = make_scheme<FeynmanNewtonPrinted, double>,
    .make_float = make_scheme<FeynmanNewtonPrinted, float>};

const IntegratorInfo schemes::feynman_newton{
    .name = "feynman-newton",
    .summary = "Feynman-Newton with the half-step start v(h/2)",
    .order_undamped = 2,
    .one_evaluation = true,
    .make_double = make_scheme<FeynmanNewton, double>,
    .make_float = make_scheme<FeynmanNewton, float>};

}  // namespace palpate
