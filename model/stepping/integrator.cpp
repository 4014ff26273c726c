// SPDX-License-Identifier: MIT
/// Base of the explicit schemes: an acceleration vector allocated before the first step.

#include "model/stepping/integrator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

#include "model/stepping/implicit_scheme.hpp"

namespace palpate {

namespace {

template <class Real> class ExplicitScheme : public Integrator<Real> {
 public:
  void prepare(System<Real>& system, const State<Real>& /*state*/, double /*h*/) override {
    a_.setZero(system.dof());
  }
  [[nodiscard]] std::size_t memory_bytes() const noexcept override { return bytes_of(a_); }

 protected:
  Vector<Real> a_;  ///< [m/s^2]
};

// Schemes whose state has the velocity at the half step: start with v(h/2), then drift and kick.

template <class Real> class StaggeredScheme : public Integrator<Real> {
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
  /// Returns the mean of the velocities half a step before and after; second-order accurate.
  const Vector<Real>& velocity_at(const State<Real>& state) noexcept override {
    mean_ = Real(0.5) * (previous_ + state.velocity);
    return mean_;
  }

  [[nodiscard]] std::size_t memory_bytes() const noexcept override {
    return bytes_of(f_, previous_, mean_);
  }

 protected:
  /// Computes f_ at t + h, the end of the step from t. Half of the kick belongs to that step and
  /// half to the next; each half uses the loads of its own step.
  void straddling_force(System<Real>& system, const State<Real>& state, double t,
                        double h) noexcept {
    const double next = load_gate(t + h, h);
    system.force(t + h, next, state.position, state.velocity, f_);
    system.add_loads(t + h, next, Real(-0.5), f_);
    system.add_loads(t + h, load_gate(t, h), Real(0.5), f_);
  }

  Vector<Real> f_;         ///< [N]
  Vector<Real> previous_;  ///< velocity at the previous half step [m/s]

 private:
  Vector<Real> mean_;
};

// v' = v + h a(x, v); x' = x + h v  (Table 1).

template <class Real> class Euler final : public ExplicitScheme<Real> {
 public:
  void step(System<Real>& system, State<Real>& state, double t, double h) noexcept override {
    const Real dt = static_cast<Real>(h);
    system.acceleration(t, load_gate(t, h), state.position, state.velocity, this->a_);
    state.position += dt * state.velocity;
    state.velocity += dt * this->a_;
  }
};

// v' = v + h a(x, v); x' = x + h v'  (Table 1), also called semi-implicit Euler.

template <class Real> class EulerCromer final : public ExplicitScheme<Real> {
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

// x' = x + h v; v' = v + h a(x', v). With the initial v at t = h/2 it is Feynman's half-step
// method. As printed in the paper, the initial v is that of t = 0, and the scheme is of order one.

template <class Real> class FeynmanNewtonPrinted final : public ExplicitScheme<Real> {
 public:
  void step(System<Real>& system, State<Real>& state, double t, double h) noexcept override {
    const Real dt = static_cast<Real>(h);
    state.position += dt * state.velocity;
    system.acceleration(t + h, load_gate(t, h), state.position, state.velocity, this->a_);
    state.velocity += dt * this->a_;
  }
};

template <class Real> class FeynmanNewton final : public StaggeredScheme<Real> {
 public:
  void step(System<Real>& system, State<Real>& state, double t, double h) noexcept override {
    const Real dt = static_cast<Real>(h);
    this->previous_ = state.velocity;
    state.position += dt * state.velocity;
    this->straddling_force(system, state, t, h);
    state.velocity += dt * system.inverse_mass().cwiseProduct(this->f_);
  }
};

// Kick and drift with the damping at the mean of the two half-step velocities: (M + h/2 C) (v+ -
// v-) = h f(x, v-);  x' = x + h v+. Second order for any damping. The matrix of the kick is
// symmetric, positive definite and close to M inside the stability limit, so conjugate gradients
// with M as preconditioner need few products and no assembled matrix.

template <class Real> class Leapfrog final : public StaggeredScheme<Real> {
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
    return StaggeredScheme<Real>::memory_bytes() +
           bytes_of(kick_, residual_, scaled_, direction_, product_);
  }

 private:
  /// Solves kick_ = (M + weight C)^-1 f_.
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
    // Squares of a very small motion underflow, and their ratios are meaningless.
    constexpr Real faintest = std::numeric_limits<Real>::min() / epsilon;
    const Real enough = std::max(epsilon * epsilon * f.dot(inverse_mass.cwiseProduct(f)), faintest);
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

// x' = x + h v + h^2/2 a;  a' = a(x', v + h a);  v' = v + h/2 (a + a').

template <class Real> class VelocityVerlet final : public ExplicitScheme<Real> {
 public:
  void prepare(System<Real>& system, const State<Real>& state, double h) override {
    ExplicitScheme<Real>::prepare(system, state, h);
    predicted_.setZero(system.dof());
    a_end_.setZero(system.dof());
  }
  void step(System<Real>& system, State<Real>& state, double t, double h) noexcept override {
    // a(t) is recomputed, because the loads and the predicted velocity at the end of the last step
    // differ.
    const Real dt = static_cast<Real>(h);
    const double gate = load_gate(t, h);
    auto& a = this->a_;
    system.acceleration(t, gate, state.position, state.velocity, a);
    state.position += dt * state.velocity + (dt * dt / 2) * a;
    predicted_ = state.velocity + dt * a;
    system.acceleration(t + h, gate, state.position, predicted_, a_end_);
    state.velocity += (dt / 2) * (a + a_end_);
  }
  [[nodiscard]] std::size_t memory_bytes() const noexcept override {
    return bytes_of(this->a_, predicted_, a_end_);
  }

 private:
  Vector<Real> predicted_;
  Vector<Real> a_end_;
};

// Classical Runge-Kutta method of order four on (x, v).

template <class Real> class RungeKutta4 final : public ExplicitScheme<Real> {
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
  [[nodiscard]] std::size_t memory_bytes() const noexcept override {
    return bytes_of(this->a_, q_, v_, dq_, dv_);
  }

 private:
  Vector<Real> q_;
  Vector<Real> v_;
  Vector<Real> dq_;  ///< weighted sum of the stage velocities
  Vector<Real> dv_;  ///< weighted sum of the stage accelerations
};

template <class Real> struct ImplicitEuler final : ImplicitScheme<Real> {
  ImplicitEuler() : ImplicitScheme<Real>(1.0) {}
};
template <class Real> struct ImplicitMidpoint final : ImplicitScheme<Real> {
  ImplicitMidpoint() : ImplicitScheme<Real>(0.5) {}
};

template <template <class> class Scheme, class Real>
std::unique_ptr<Integrator<Real>> make_scheme() {
  return std::make_unique<Scheme<Real>>();
}

template <template <class> class Scheme>
constexpr IntegratorInfo registered(IntegratorInfo properties) {
  properties.make_double = make_scheme<Scheme, double>;
  properties.make_float = make_scheme<Scheme, float>;
  return properties;
}

/// Registered schemes; a new scheme is one more entry here.
constexpr std::array registry{
    registered<Euler>(
        {.name = "euler", .summary = "explicit Euler, Table 1", .one_evaluation = true}),
    registered<EulerCromer>({.name = "euler-cromer",
                             .summary = "semi-implicit Euler, Table 1",
                             .one_evaluation = true}),
    registered<FeynmanNewton>({.name = "feynman-newton",
                               .summary = "Feynman-Newton with the half-step start v(h/2)",
                               .order_undamped = 2,
                               .one_evaluation = true}),
    registered<FeynmanNewtonPrinted>(
        {.name = "feynman-newton-printed",
         .summary = "Feynman-Newton as printed in Table 1: starts from v(0)",
         .one_evaluation = true}),
    registered<Leapfrog>({.name = "leapfrog",
                          .summary = "leapfrog with centred damping",
                          .order_undamped = 2,
                          .order_damped = 2}),
    registered<VelocityVerlet>({.name = "velocity-verlet",
                                .summary = "velocity Verlet, predicted damping",
                                .order_undamped = 2,
                                .order_damped = 2,
                                .evaluations = 2}),
    registered<RungeKutta4>({.name = "rk4",
                             .summary = "classical Runge-Kutta",
                             .order_undamped = 4,
                             .order_damped = 4,
                             .evaluations = 4}),
    registered<ImplicitEuler>(
        {.name = "implicit-euler", .summary = "implicit Euler, sparse Newton", .implicit = true}),
    registered<ImplicitMidpoint>({.name = "implicit-midpoint",
                                  .summary = "implicit midpoint rule, sparse Newton",
                                  .order_undamped = 2,
                                  .order_damped = 2,
                                  .implicit = true})};

constexpr auto pointers =
    std::apply([](const auto&... entries) { return std::array{&entries...}; }, registry);

}  // namespace

std::span<const IntegratorInfo* const> integrators() { return pointers; }

const IntegratorInfo* find_integrator(std::string_view name) {
  const auto found = std::ranges::find(registry, name, &IntegratorInfo::name);
  return found == registry.end() ? nullptr : &*found;
}

}  // namespace palpate
