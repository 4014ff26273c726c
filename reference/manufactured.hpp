// SPDX-License-Identifier: MIT
#pragma once
/// A problem whose exact solution is chosen: any Problem, pushed by the force M q*'' - f(t, q*,
/// q*') so that it moves along q*. The method of manufactured solutions, with every spring at work.

#include <Eigen/Core>

#include "model/dynamics/problem.hpp"

namespace palpate::reference {

/// q*_i(t) = q_i(0) + A_i (1 + s^2 (3 - 2 s)) sin(w_i t + phi_i), s = t / duration; A_i, w_i and
/// phi_i vary from coordinate to coordinate around these.
struct ManufacturedMotion {
  double amplitude = 1e-3;   ///< [m]
  double frequency = 100.0;  ///< [rad/s]
  double duration = 0.1;     ///< [s]
};

class ManufacturedProblem final : public Problem {
 public:
  /// `base` must outlive it. Its loads cancel.
  ManufacturedProblem(const Problem& base, const ManufacturedMotion& motion);

  [[nodiscard]] Eigen::VectorXd exact_position(double t) const;      ///< q*(t) [m]
  [[nodiscard]] Eigen::VectorXd exact_velocity(double t) const;      ///< [m/s]
  [[nodiscard]] Eigen::VectorXd exact_acceleration(double t) const;  ///< [m/s^2]

  [[nodiscard]] Eigen::Index dof() const override { return base_->dof(); }
  [[nodiscard]] const Eigen::VectorXd& mass() const override { return base_->mass(); }
  [[nodiscard]] Eigen::VectorXd initial_position() const override { return exact_position(0.0); }
  [[nodiscard]] Eigen::VectorXd initial_velocity() const override { return exact_velocity(0.0); }
  void force(double t, double gate, const Eigen::Ref<const Eigen::VectorXd>& q,
             const Eigen::Ref<const Eigen::VectorXd>& v,
             Eigen::Ref<Eigen::VectorXd> f) const override;
  void jacobian(const Eigen::Ref<const Eigen::VectorXd>& q,
                const Eigen::Ref<const Eigen::VectorXd>& v, Eigen::SparseMatrix<double>& stiffness,
                Eigen::SparseMatrix<double>& damping) const override {
    base_->jacobian(q, v, stiffness, damping);
  }
  [[nodiscard]] std::vector<double> breaks() const override { return base_->breaks(); }
  [[nodiscard]] double shortest_feature() const override;
  [[nodiscard]] double energy(const Eigen::Ref<const Eigen::VectorXd>& q,
                              const Eigen::Ref<const Eigen::VectorXd>& v) const override {
    return base_->energy(q, v);
  }

 private:
  const Problem* base_;
  ManufacturedMotion motion_;
  Eigen::ArrayXd origin_;     ///< [m]
  Eigen::ArrayXd amplitude_;  ///< [m]
  Eigen::ArrayXd frequency_;  ///< [rad/s]
  Eigen::ArrayXd phase_;      ///< [rad]
};

}  // namespace palpate::reference
