// SPDX-License-Identifier: MIT
#pragma once
/// Implicit one-stage scheme with parameter theta. The unknown is the velocity change D in a step:
///   vs = v + theta D,  qs = q + theta h vs,  M D = h f(t + theta h, qs, vs);
///   v' = v + D,  q' = q + h vs.
/// theta = 1 is implicit Euler, theta = 1/2 is the implicit midpoint rule. Newton's method uses a
/// sparse LDL^T factorisation that is computed once, before the first step, and includes the active
/// contact constraints. If it converges too slowly with these factors alone, the complete Jacobian
/// is assembled and kept while it converges. Each linear system is then solved by BiCGSTAB with the
/// factors as preconditioner.

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
  /// Computes change_ with Newton's method, starting from the previous change. Diverging
  /// corrections are halved at most `halvings` times. Returns false if the iteration does not
  /// converge.
  bool find_change(System<Real>& system, const State<Real>& state, double t, double h,
                   int halvings) noexcept;
  [[nodiscard]] bool residual_is_rounding(Real h) const noexcept;

  double theta_;
  double tolerance_ = 0.0;     ///< relative tolerance of the velocity change in a step; 0: rounding
  Real rate_ = Real(1);        ///< contraction rate with the Jacobian
  Real rate_alone_ = Real(1);  ///< contraction rate with the factors alone
  bool alone_ = false;         ///< use the factors in place of the Jacobian
  bool renew_ = true;          ///< a_ must be recomputed
  Real reach_ = Real(0);       ///< theta h of a_
  Eigen::SparseMatrix<Real> a_;
  SupernodeFactors<Real> factors_{};
  Real factor_reach_ = Real(0);   ///< theta h of the factors, which are valid for this value only
  Vector<Real> elastic_;          ///< diagonal of the Jacobian without the masses
  Real elastic_reach_ = Real(0);  ///< theta h of elastic_
  Vector<Real> change_, stage_q_, stage_v_, force_, residual_, correction_, taken_, guess_;
  Vector<Real> r_, shadow_, p_, p_hat_, s_hat_, v_, t_;
};

}  // namespace palpate
