// SPDX-License-Identifier: MIT

#include "model/stepping/implicit_scheme.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate {

namespace {
constexpr int most_newton_iterations = 25;
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
/// Contraction rate up to which the factors alone replace the Jacobian, and the number of remaining
/// iterations up to which they do: the cost of computing the Jacobian and solving with it.
constexpr double serves_alone = 0.1;
constexpr int most_alone = 8;
}  // namespace

template <class Real>
void ImplicitScheme<Real>::prepare(System<Real>& system, const State<Real>& state, double h) {
  const Eigen::Index n = system.dof();
  for (Vector<Real>* work : {&change_, &stage_q_, &stage_v_, &force_, &residual_, &correction_,
                             &taken_, &guess_, &r_, &shadow_, &p_, &p_hat_, &s_hat_, &v_, &t_}) {
    work->setZero(n);
  }
  system.pattern(a_);
  // The Jacobian is symmetric at zero velocity.
  const Real th = static_cast<Real>(theta_ * h);
  system.jacobian(state.position, stage_v_, th, th * th, a_);
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<Real>> factors(a_);
  if (factors.info() == Eigen::Success) { factors_.take(factors); }
  elastic_ = a_.diagonal() - system.mass();
  factor_reach_ = elastic_reach_ = th;
  system.learn_compliance(
      [this](const Vector<Real>& right, Vector<Real>& solution) { precondition(right, solution); });
}

template <class Real>
void ImplicitScheme<Real>::precondition(const Vector<Real>& r, Vector<Real>& out) noexcept {
  if (factors_.usable()) {
    factors_.solve(r, out);
  } else {
    out = r;
  }
}

template <class Real>
void ImplicitScheme<Real>::solve(System<Real>& system, const Vector<Real>& right) noexcept {
  correction_.setZero();
  const Real size = right.template lpNorm<Eigen::Infinity>();
  if (size == Real(0)) { return; }
  r_ = right / size;  // scaled to norm one to avoid overflow and underflow of squares
  system.begin_linear_solve();
  if (alone_) {
    precondition(r_, correction_);
    system.constrain_solution(r_, correction_);
    correction_ *= size;
    return;
  }
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
template <class Real> bool ImplicitScheme<Real>::residual_is_rounding(Real h) const noexcept {
  constexpr Real roundings = 8 * std::numeric_limits<Real>::epsilon();
  const Real reach = roundings * stage_q_.template lpNorm<Eigen::Infinity>() * h /
                     (elastic_reach_ * elastic_reach_);
  // The transverse stiffness of compressed springs can make their part of the diagonal negative.
  return (residual_.array().abs() <= reach * elastic_.array().abs()).all();
}

template <class Real>
void ImplicitScheme<Real>::step(System<Real>& system, State<Real>& state, double t,
                                double h) noexcept {
  guess_ = change_;
  for (const int halvings : {0, most_halvings}) {
    if (find_change(system, state, t, h, halvings)) {
      stage_v_ = state.velocity + static_cast<Real>(theta_) * change_;
      state.position += static_cast<Real>(h) * stage_v_;
      state.velocity += change_;
      return;
    }
    change_ = guess_;
    renew_ = true;
  }
  state.velocity.setConstant(std::numeric_limits<Real>::quiet_NaN());  // no solution was found
}

template <class Real>
bool ImplicitScheme<Real>::find_change(System<Real>& system, const State<Real>& state, double t,
                                       double h, int halvings) noexcept {
  const Real dt = static_cast<Real>(h);
  const Real theta = static_cast<Real>(theta_);
  const Real th = theta * dt;
  const Real rounding = 64 * std::numeric_limits<Real>::epsilon();
  const Real tolerance = std::max(static_cast<Real>(tolerance_), rounding);
  const Real noise = std::max(Real(1e4) * rounding, static_cast<Real>(stagnant));
  Real last = std::numeric_limits<Real>::infinity();
  Real scale = Real(0);
  alone_ = factors_.usable() && th == factor_reach_;
  const int most = most_newton_iterations + halvings;
  for (int n = 0; n < most; ++n) {
    stage_v_ = state.velocity + theta * change_;
    stage_q_ = state.position + th * stage_v_;
    system.force(t + theta_ * h, load_gate(t, h), stage_q_, stage_v_, force_);
    residual_ = dt * force_ - system.mass().cwiseProduct(change_);
    if (!residual_.allFinite()) { break; }  // the norms below can miss a NaN
    if (!alone_ && (renew_ || reach_ != th)) {
      system.jacobian(stage_q_, stage_v_, th, th * th, a_);
      elastic_ = a_.diagonal() - system.mass();
      reach_ = elastic_reach_ = th;
    }
    const bool at_rounding = residual_is_rounding(dt);
    solve(system, residual_);
    const Real size = correction_.template lpNorm<Eigen::Infinity>();
    // A correction that moves every position by a few roundings at most is noise as well.
    const auto is_noise = [&] {
      return size <= noise * scale || th * size <= 4 * std::numeric_limits<Real>::epsilon() *
                                                       stage_q_.template lpNorm<Eigen::Infinity>();
    };
    // Far from the solution a full correction can increase the error (Deuflhard's natural
    // monotonicity).
    if (halvings > 0 && n > 0 && !(size <= static_cast<Real>(growth) * last) && !is_noise()) {
      --halvings;
      taken_ *= Real(0.5);
      change_ -= taken_;
      alone_ = false;
      renew_ = true;
      continue;
    }
    if (halvings > 0) { taken_ = correction_; }
    change_ += correction_;
    scale = state.velocity.template lpNorm<Eigen::Infinity>() +
            change_.template lpNorm<Eigen::Infinity>();
    // Corrections decrease at a constant rate that is limited by the accuracy of the linear solve;
    // the remaining error is their geometric series. The first correction uses the rate of the step
    // before, with decreasing confidence (Hairer & Wanner).
    Real& rate = alone_ ? rate_alone_ : rate_;
    rate = std::max(n == 0 ? std::pow(rate, Real(0.8)) : size / last, static_cast<Real>(close));
    if (!alone_) { renew_ = n > 0 && rate > still_good; }
    const Real asked = tolerance * scale * (Real(1) - rate);
    const bool settled = rate < Real(1) && size * rate <= asked;
    const bool stalled = size >= last && is_noise();
    if (settled || stalled || at_rounding) { return true; }
    alone_ = alone_ &&
             (n == 0 || rate <= serves_alone || size * std::pow(rate, Real(most_alone)) <= asked);
    last = size;
  }
  return false;
}

template class ImplicitScheme<double>;
template class ImplicitScheme<float>;

}  // namespace palpate
