// SPDX-License-Identifier: MIT
/// Time integrators and their registry.

#include "model/stepping/integrator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

#include "model/kernels/dissection.hpp"
#include "model/kernels/supernode_factors.hpp"
#include "model/stepping/anderson_iteration.hpp"

namespace palpate {

namespace {

/// Scheme with `count` vectors of all coordinates, allocated before the first step.
template <class Real, std::size_t count> class SchemeWith : public Integrator<Real> {
 public:
  void prepare(System<Real>& system, const State<Real>& /*state*/, double /*h*/) override {
    for (Vector<Real>& vector : work_) { vector.setZero(system.dof()); }
  }
  [[nodiscard]] std::size_t memory_bytes() const noexcept override {
    return std::apply([](const auto&... vectors) { return bytes_of(vectors...); }, work_);
  }

 protected:
  std::array<Vector<Real>, count> work_;
};

template <class Real, std::size_t further = 0>
class ExplicitScheme : public SchemeWith<Real, 1 + further> {
 protected:
  Vector<Real>& a_ = this->work_[further];  ///< [m/s^2]
};

// Schemes whose state has the velocity at the half step: start with v(h/2), then drift and kick.

template <class Real, std::size_t further = 0>
class StaggeredScheme : public SchemeWith<Real, 3 + further> {
 public:
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

  Vector<Real>& f_ = this->work_[further];             ///< [N]
  Vector<Real>& previous_ = this->work_[further + 1];  ///< velocity half a step before [m/s]

 private:
  Vector<Real>& mean_ = this->work_[further + 2];
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

template <class Real> class Leapfrog final : public StaggeredScheme<Real, 5> {
 public:
  void step(System<Real>& system, State<Real>& state, double t, double h) noexcept override {
    const Real dt = static_cast<Real>(h);
    this->previous_ = state.velocity;
    state.position += dt * state.velocity;
    this->straddling_force(system, state, t, h);
    this->f_ *= dt;
    solve_kick(system, state.position, dt / 2);
    state.velocity += kick_;
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
  Vector<Real>& kick_ = this->work_[0];
  Vector<Real>& residual_ = this->work_[1];
  Vector<Real>& scaled_ = this->work_[2];
  Vector<Real>& direction_ = this->work_[3];
  Vector<Real>& product_ = this->work_[4];
};

// x' = x + h v + h^2/2 a;  a' = a(x', v + h a);  v' = v + h/2 (a + a').

template <class Real> class VelocityVerlet final : public ExplicitScheme<Real, 2> {
 public:
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

 private:
  Vector<Real>& predicted_ = this->work_[0];
  Vector<Real>& a_end_ = this->work_[1];
};

// Classical Runge-Kutta method of order four on (x, v).

template <class Real> class RungeKutta4 final : public ExplicitScheme<Real, 4> {
 public:
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

 private:
  Vector<Real>& q_ = this->work_[0];
  Vector<Real>& v_ = this->work_[1];
  Vector<Real>& dq_ = this->work_[2];  ///< weighted sum of the stage velocities
  Vector<Real>& dv_ = this->work_[3];  ///< weighted sum of the stage accelerations
};

// Implicit schemes.

constexpr int most_accelerated_iterations = 25;
constexpr int most_newton_iterations = 37;
/// Maximum number of halvings of a correction that increased the next one.
constexpr int most_halvings = 12;
/// Growth factor of a correction above which it is halved.
constexpr double growth = 2.0;
/// Relative size below which corrections that no longer decrease are rounding error of a nearly
/// singular Jacobian.
constexpr double stagnant = 1e-8;
constexpr int most_linear_iterations = 100;
/// Relative residual of a linear solve; Newton's method corrects the rest.
constexpr double close = 1e-2;
/// Contraction rate up to which a Jacobian is kept, also over several steps.
constexpr double still_good = 0.05;

/// Implicit one-stage scheme with parameter theta. The unknown is the velocity change D in a step:
///   vs = v + theta D,  qs = q + theta h vs,  M D = h f(t + theta h, qs, vs);
///   v' = v + D,  q' = q + h vs.
/// theta = 1 is implicit Euler, theta = 1/2 is the implicit midpoint rule. A sparse LDL^T
/// factorisation P is computed once, before the first step; it includes the active contact
/// constraints. Anderson's iteration with P solves a step. If it does not converge, Newton's method
/// assembles the Jacobian and solves each linear system by BiCGSTAB with the preconditioner P.
template <class Real> class ImplicitScheme : public Integrator<Real> {
 public:
  explicit ImplicitScheme(double theta) : theta_(theta) {}
  void set_tolerance(double relative, int most_corrections) noexcept override {
    tolerance_ = relative;
    most_corrections_ = most_corrections;
  }
  [[nodiscard]] LimitedSteps limited_steps() const noexcept override { return limited_; }
  void prepare(System<Real>& system, const State<Real>& state, double h) override {
    const Eigen::Index n = system.dof();
    for (Vector<Real>* work : {&change_, &stage_q_, &stage_v_, &force_, &residual_, &correction_,
                               &taken_, &guess_, &r_, &shadow_, &p_, &p_hat_, &s_hat_, &v_, &t_}) {
      work->setZero(n);
    }
    anderson_.prepare(n);
    system.pattern(a_);
    // The Jacobian is symmetric at zero velocity.
    const Real th = static_cast<Real>(theta_ * h);
    system.jacobian(state.position, stage_v_, th, th * th, a_);
    factors_.factorise(a_, nested_dissection(a_, system.places()));
    elastic_ = a_.diagonal() - system.mass();
    factor_reach_ = elastic_reach_ = th;
    system.learn_compliance([this](const Vector<Real>& right, Vector<Real>& solution) {
      precondition(right, solution);
    });
  }

  void step(System<Real>& system, State<Real>& state, double t, double h) noexcept override {
    guess_ = change_;
    bool solved = accelerate(system, state, t, h);
    if (!solved) {
      change_ = guess_;
      renew_ = true;
      solved = newton(system, state, t, h);
    }
    if (solved) {
      stage_v_ = state.velocity + static_cast<Real>(theta_) * change_;
      state.position += static_cast<Real>(h) * stage_v_;
      state.velocity += change_;
      return;
    }
    change_ = guess_;
    state.velocity.setConstant(std::numeric_limits<Real>::quiet_NaN());  // no solution was found
  }

  [[nodiscard]] std::size_t memory_bytes() const noexcept override {
    const auto entries = static_cast<std::size_t>(a_.nonZeros());
    return entries * (sizeof(Real) + sizeof(int)) + factors_.memory_bytes() +
           anderson_.memory_bytes() +
           bytes_of(elastic_, change_, stage_q_, stage_v_, force_, residual_, correction_, taken_,
                    guess_, r_, shadow_, p_, p_hat_, s_hat_, v_, t_);
  }

 private:
  void precondition(const Vector<Real>& r, Vector<Real>& out) noexcept {
    if (factors_.usable()) {
      factors_.solve(r, out);
    } else {
      out = r;
    }
  }

  /// Computes correction_ = P^-1 residual_ under the active constraints.
  void correct_alone(System<Real>& system) noexcept {
    const Real size = residual_.template lpNorm<Eigen::Infinity>();
    if (size == Real(0)) {
      correction_.setZero();
      return;
    }
    r_ = residual_ / size;  // scaled to norm one to avoid overflow and underflow
    system.begin_linear_solve();
    precondition(r_, correction_);
    system.constrain_solution(r_, correction_);
    correction_ *= size;
  }

  /// Computes correction_ = A^-1 residual_ under the active constraints.
  void solve(System<Real>& system) noexcept {
    correction_.setZero();
    const Real size = residual_.template lpNorm<Eigen::Infinity>();
    if (size == Real(0)) { return; }
    r_ = residual_ / size;  // scaled to norm one to avoid overflow and underflow of squares
    system.begin_linear_solve();
    shadow_ = r_;
    p_.setZero();
    v_.setZero();
    Real rho = 1;
    Real alpha = 1;
    Real omega = 1;
    const Real enough = static_cast<Real>(close) * r_.norm();
    for (int n = 0; n < most_linear_iterations && r_.norm() > enough; ++n) {
      const Real next = shadow_.dot(r_);
      p_ = r_ + (next / rho * (alpha / omega)) * (p_ - omega * v_);
      rho = next;
      precondition(p_, p_hat_);
      system.constrain_solution(p_, p_hat_);
      v_.noalias() = a_ * p_hat_;
      system.hold(p_hat_, v_);
      alpha = rho / shadow_.dot(v_);
      correction_ += alpha * p_hat_;
      r_ -= alpha * v_;
      if (!(r_.norm() > enough)) { break; }
      precondition(r_, s_hat_);
      system.constrain_solution(r_, s_hat_);
      t_.noalias() = a_ * s_hat_;
      system.hold(s_hat_, t_);
      omega = t_.dot(r_) / t_.squaredNorm();
      correction_ += omega * s_hat_;
      r_ -= omega * t_;
    }
    correction_ *= size;
  }

  /// Returns true if the residual is rounding error. Rounding of the positions changes the residual
  /// by h K times that rounding. (theta h)^2 K_ii <= A_ii - M_ii if all springs are stretched, for
  /// the h of that A.
  [[nodiscard]] bool residual_is_rounding(Real h) const noexcept {
    constexpr Real roundings = 8 * std::numeric_limits<Real>::epsilon();
    const Real reach = roundings * stage_q_.template lpNorm<Eigen::Infinity>() * h /
                       (elastic_reach_ * elastic_reach_);
    // The transverse stiffness of compressed springs can make their part of the diagonal negative.
    return (residual_.array().abs() <= reach * elastic_.array().abs()).all();
  }

  /// Computes the residual of change_. Returns false if it is not finite.
  bool evaluate(System<Real>& system, const State<Real>& state, double t, double h) noexcept {
    const Real theta = static_cast<Real>(theta_);
    stage_v_ = state.velocity + theta * change_;
    stage_q_ = state.position + theta * static_cast<Real>(h) * stage_v_;
    system.force(t + theta_ * h, load_gate(t, h), stage_q_, stage_v_, force_);
    residual_ = static_cast<Real>(h) * force_ - system.mass().cwiseProduct(change_);
    return residual_.allFinite();  // norms can miss a NaN
  }
  /// Returns true if a correction is rounding error: relative to the velocities, or if it moves
  /// every position by a few roundings at most.
  [[nodiscard]] bool is_noise(Real size, Real th) const noexcept {
    const Real noise =
        std::max(Real(64e4) * std::numeric_limits<Real>::epsilon(), static_cast<Real>(stagnant));
    return size <= noise * scale_ || th * size <= 4 * std::numeric_limits<Real>::epsilon() *
                                                      stage_q_.template lpNorm<Eigen::Infinity>();
  }
  /// Returns true if change_ is accurate enough after a correction of this size. The remaining
  /// error is the geometric series of corrections that decrease by `rate`.
  [[nodiscard]] bool is_settled(const State<Real>& state, Real th, Real size, Real last,
                                Real rate) noexcept {
    const Real tolerance =
        std::max(static_cast<Real>(tolerance_), Real(64) * std::numeric_limits<Real>::epsilon());
    scale_ = state.velocity.template lpNorm<Eigen::Infinity>() +
             change_.template lpNorm<Eigen::Infinity>();
    return (rate < Real(1) && size * rate <= tolerance * scale_ * (Real(1) - rate)) ||
           (size >= last && is_noise(size, th));
  }
  /// Returns the rate at which corrections decrease. The first correction of a step uses the rate
  /// of the step before, with decreasing confidence (Hairer & Wanner).
  [[nodiscard]] static Real rate_after(int n, Real before, Real now) noexcept {
    return std::max(n == 0 ? std::pow(before, Real(0.8)) : now, static_cast<Real>(close));
  }

  /// Computes change_ by Anderson's iteration, starting from the previous change. Returns false if
  /// it does not converge.
  bool accelerate(System<Real>& system, const State<Real>& state, double t, double h) noexcept {
    const Real th = static_cast<Real>(theta_) * static_cast<Real>(h);
    if (!factors_.usable() || th != factor_reach_) { return false; }
    if (const long set = system.constraint_set(); set != constraint_set_) {
      anderson_.forget();
      constraint_set_ = set;
    }
    anderson_.start();
    Real last = std::numeric_limits<Real>::infinity();
    for (int n = 0; n < most_accelerated_iterations; ++n) {
      if (!evaluate(system, state, t, h)) { return false; }
      const bool at_rounding = residual_is_rounding(static_cast<Real>(h));
      correct_alone(system);
      const Real ratio = anderson_.advance(change_, correction_);
      const Real size = correction_.template lpNorm<Eigen::Infinity>();
      change_ += correction_;
      rate_alone_ = rate_after(n, rate_alone_, std::max(size / last, ratio));
      if (is_settled(state, th, size, last, rate_alone_) || at_rounding) { return true; }
      if (most_corrections_ > 0 && n + 1 >= most_corrections_ && size < last) {
        ++limited_.count;
        limited_.largest_correction =
            std::max(limited_.largest_correction, static_cast<double>(size / scale_));
        return true;
      }
      last = size;
    }
    return false;
  }

  /// Computes change_ with Newton's method, starting from the previous change. Diverging
  /// corrections are halved. Returns false if the iteration does not converge.
  bool newton(System<Real>& system, const State<Real>& state, double t, double h) noexcept {
    const Real th = static_cast<Real>(theta_) * static_cast<Real>(h);
    Real last = std::numeric_limits<Real>::infinity();
    int halvings = most_halvings;
    scale_ = Real(0);
    for (int n = 0; n < most_newton_iterations; ++n) {
      if (!evaluate(system, state, t, h)) { return false; }
      if (renew_ || reach_ != th) {
        system.jacobian(stage_q_, stage_v_, th, th * th, a_);
        elastic_ = a_.diagonal() - system.mass();
        reach_ = elastic_reach_ = th;
      }
      const bool at_rounding = residual_is_rounding(static_cast<Real>(h));
      solve(system);
      const Real size = correction_.template lpNorm<Eigen::Infinity>();
      // Far from the solution a full correction can increase the error (Deuflhard's natural
      // monotonicity).
      if (halvings > 0 && n > 0 && !(size <= static_cast<Real>(growth) * last) &&
          !is_noise(size, th)) {
        --halvings;
        taken_ *= Real(0.5);
        change_ -= taken_;
        renew_ = true;
        continue;
      }
      taken_ = correction_;
      change_ += correction_;
      // Limited by the accuracy of the linear solve.
      rate_ = rate_after(n, rate_, size / last);
      renew_ = n > 0 && rate_ > still_good;
      if (is_settled(state, th, size, last, rate_) || at_rounding) { return true; }
      last = size;
    }
    return false;
  }

  double theta_;
  double tolerance_ = 0.0;    ///< relative tolerance of the velocity change in a step; 0: rounding
  int most_corrections_ = 0;  ///< of a step of Anderson's iteration; 0: no limit
  LimitedSteps limited_{};
  Real rate_ = Real(1);        ///< contraction rate with the Jacobian
  Real rate_alone_ = Real(1);  ///< contraction rate of Anderson's iteration
  Real scale_ = Real(0);       ///< velocities to which the tolerance is relative [m/s]
  AndersonIteration<Real> anderson_{};
  long constraint_set_ = 0;  ///< that of the pairs of anderson_
  bool renew_ = true;        ///< a_ must be recomputed
  Real reach_ = Real(0);     ///< theta h of a_
  Eigen::SparseMatrix<Real> a_;
  SupernodeFactors<Real> factors_{};
  Real factor_reach_ = Real(0);   ///< theta h of the factors, which are valid for this value only
  Vector<Real> elastic_;          ///< diagonal of the Jacobian without the masses
  Real elastic_reach_ = Real(0);  ///< theta h of elastic_
  Vector<Real> change_, stage_q_, stage_v_, force_, residual_, correction_, taken_, guess_;
  Vector<Real> r_, shadow_, p_, p_hat_, s_hat_, v_, t_;
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
    registered<ImplicitEuler>({.name = "implicit-euler",
                               .summary = "implicit Euler, sparse Newton",
                               .implicit = true,
                               .theta = 1.0}),
    registered<ImplicitMidpoint>({.name = "implicit-midpoint",
                                  .summary = "implicit midpoint rule, sparse Newton",
                                  .order_undamped = 2,
                                  .order_damped = 2,
                                  .implicit = true,
                                  .theta = 0.5})};

constexpr auto pointers =
    std::apply([](const auto&... entries) { return std::array{&entries...}; }, registry);

}  // namespace

std::span<const IntegratorInfo* const> integrators() { return pointers; }

const IntegratorInfo* find_integrator(std::string_view name) {
  const auto found = std::ranges::find(registry, name, &IntegratorInfo::name);
  return found == registry.end() ? nullptr : &*found;
}

}  // namespace palpate
