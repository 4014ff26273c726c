// SPDX-License-Identifier: MIT
#pragma once
/// One implicit stage at theta of the step, for the velocity change D over the step:
///   vs = v + theta D,  qs = q + theta h vs,  M D = h f(t + theta h, qs, vs);  v' = v + D, q' = q +
///   h vs.
/// theta = 1 is implicit Euler, theta = 1/2 the implicit midpoint rule. Newton's method with a
/// sparse LDL^T factorisation that is made once, before the loop, and with what sticks to a tool
/// held in it. While that serves it stands for the Jacobian; else the complete Jacobian is kept
/// while it serves, and each linear system solved by BiCGSTAB, which the factors precondition.

#include <memory>

#include "model/kernels/supernode_factors.hpp"
#include "model/stepping/integrator.hpp"

namespace palpate {

template <class Real> class ImplicitScheme : public Integrator<Real> {
 public:
  explicit ImplicitScheme(double theta) : theta_(theta) {}
  void prepare(System<Real>& system, const State<Real>& state, double h) override;
  void set_tolerance(double relative) noexcept override { tolerance_ = relative; }
  void step(System<Real>& system, State<Real>& state, double t, double h) noexcept override;

  [[nodiscard]] std::size_t memory_bytes() const noexcept override {
    const auto entries = static_cast<std::size_t>(a_.nonZeros());
    return entries * (sizeof(Real) + sizeof(int)) + factors_.memory_bytes() +
           bytes_of(elastic_, change_, stage_q_, stage_v_, force_, residual_, correction_, taken_,
                    guess_, r_, shadow_, p_, p_hat_, s_hat_, v_, t_);
  }

 private:
  void precondition(const Vector<Real>& r, Vector<Real>& out) noexcept;
  void solve(System<Real>& system,
             const Vector<Real>& right) noexcept;  ///< correction_ = A^-1 right
  /// D from the one before, to change_; false where Newton's method does not end. So many
  /// corrections are halved that lead away.
  bool find_change(System<Real>& system, const State<Real>& state, double t, double h,
                   int halvings) noexcept;
  [[nodiscard]] bool residual_is_rounding(Real h) const noexcept;

  double theta_;
  double tolerance_ = 0.0;     ///< on the change of velocity over a step, relative; 0: rounding
  Real rate_ = Real(1);        ///< by which corrections shrink with the Jacobian
  Real rate_alone_ = Real(1);  ///< and with the factors alone
  bool alone_ = false;         ///< the factors stand for the Jacobian
  bool renew_ = true;          ///< a_ is to be computed again
  Real reach_ = Real(0);       ///< theta h that a_ was computed for
  Eigen::SparseMatrix<Real> a_;
  SupernodeFactors<Real> factors_{};
  Real factor_reach_ = Real(0);  ///< theta h of the factors, which serve steps of that length alone
  Vector<Real> elastic_;         ///< diagonal of the Jacobian without the masses
  Real elastic_reach_ = Real(0);  ///< theta h of that
  Vector<Real> change_, stage_q_, stage_v_, force_, residual_, correction_, taken_, guess_;
  Vector<Real> r_, shadow_, p_, p_hat_, s_hat_, v_, t_;
};

}  // namespace palpate
