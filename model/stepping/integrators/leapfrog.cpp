// SPDX-License-Identifier: MIT
/// Kick and drift with the damping taken at the mean of the two half-step velocities:
/// (M + h/2 C) (v+ - v-) = h f(x, v-);  x' = x + h v+. Order two for every damping. The kick's
/// matrix is symmetric and positive definite and near M inside the stability limit, so conjugate
/// gradients with M as preconditioner need few products and no matrix.
#include <algorithm>
#include <limits>

#include "model/stepping/integrators/explicit_scheme.hpp"
#include "model/stepping/integrators/schemes.hpp"
#include "model/stepping/integrators/staggered_scheme.hpp"

namespace palpate {
namespace {

template <class Real>
class Leapfrog final : public StaggeredScheme<Real> {
 public:
  void prepare(System<Real>& system, const State<Real>& state, double h) override {
    StaggeredScheme<Real>::prepare(system, state, h);
    for (Vector<Real>* work : {&kick_, &residual_, &scaled_, &direction_, &product_}) {
      work->setZero(system.dof());
    }
  }
  void step(System<Real>& system, State<Real>& state, double t, double h) noexcept override {
    const Real dt = static_cast<Real>(h);
    this->previous_ = state.velocity;
    state.position += dt * state.velocity;
    this->straddling_force(system, state, t, h);
    this->f_ *= dt;
    solve_kick(system, state.position, dt / 2);
    state.velocity += kick_;
  }
  [[nodiscard]] std::size_t memory_bytes() const noexcept override {
    return StaggeredScheme<Real>::memory_bytes() + bytes_of(kick_, residual_, scaled_, direction_, product_);
  }

 private:
  /// kick_ = (M + weight C)^-1 f_.
  void solve_kick(System<Real>& system, const Vector<Real>& q, Real weight) noexcept {
    auto& solution = kick_;
    const auto& f = this->f_;
    const auto& inverse_mass = system.inverse_mass();
    solution = inverse_mass.cwiseProduct(f);
    if (!system.has_dampers()) { return; }
    system.damping(q, solution, product_);
    residual_ = -weight * product_;  // f - (M + weight C) M^-1 f
    scaled_ = inverse_mass.cwiseProduct(residual_);
    direction_ = scaled_;
    Real rho = residual_.dot(scaled_);
    constexpr Real epsilon = std::numeric_limits<Real>::epsilon();
    // Squares of a motion that has all but died out underflow, and ratios of them mean nothing.
    constexpr Real faintest = std::numeric_limits<Real>::min() / epsilon;
    const Real enough =
        std::max(epsilon * epsilon * f.dot(inverse_mass.cwiseProduct(f)), faintest);
    for (int n = 0; n < most_iterations && rho > enough; ++n) {
      system.damping(q, direction_, product_);
      product_ = system.mass().cwiseProduct(direction_) + weight * product_;
      const Real alpha = rho / direction_.dot(product_);
      solution += alpha * direction_;
      residual_ -= alpha * product_;
      scaled_ = inverse_mass.cwiseProduct(residual_);
      const Real next = residual_.dot(scaled_);
      direction_ = scaled_ + (next / rho) * direction_;
      rho = next;
    }
  }

  static constexpr int most_iterations = 200;
  Vector<Real> kick_;
  Vector<Real> residual_;
  Vector<Real> scaled_;
  Vector<Real> direction_;
  Vector<Real> product_;
};

}  // namespace

const IntegratorInfo schemes::leapfrog{.name = "leapfrog",
                                       .summary = "leapfrog with centred damping",
                                       .order_undamped = 2,
                                       .order_damped = 2,
                                       .make_double = make_scheme<Leapfrog, double>,
                                       .make_float = make_scheme<Leapfrog, float>};

}  // namespace palpate
