// SPDX-License-Identifier: MIT
#pragma once
/// Linearised scene: an exactly solvable problem of the same kind and size.

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "model/problem/problem.hpp"

namespace palpate::reference {

/// Returns the rest positions of a network, 0 for the oscillator, or the initial position of any
/// other problem [m].
Eigen::VectorXd rest_coordinates(const Problem& problem);

/// Problem that forwards every function to `base`, which must outlive it.
class DerivedProblem : public Problem {
 public:
  explicit DerivedProblem(const Problem& base) : base_(&base) {}

  [[nodiscard]] Eigen::Index dof() const override { return base_->dof(); }
  [[nodiscard]] const Eigen::VectorXd& mass() const override { return base_->mass(); }
  [[nodiscard]] Eigen::VectorXd initial_position() const override {
    return base_->initial_position();
  }
  [[nodiscard]] Eigen::VectorXd initial_velocity() const override {
    return base_->initial_velocity();
  }
  void force(double t, double gate, const Coordinates& q, const Coordinates& v,
             Eigen::Ref<Eigen::VectorXd> f) const override {
    base_->force(t, gate, q, v, f);
  }
  void jacobian(const Coordinates& q, const Coordinates& v, JacobianMatrix& stiffness,
                Eigen::SparseMatrix<double>& damping) const override {
    base_->jacobian(q, v, stiffness, damping);
  }
  [[nodiscard]] std::vector<double> breaks() const override { return base_->breaks(); }
  [[nodiscard]] double shortest_feature() const override { return base_->shortest_feature(); }
  [[nodiscard]] double energy(const Coordinates& q, const Coordinates& v) const override {
    return base_->energy(q, v);
  }

 protected:
  const Problem* base_;
};

/// Linear problem M q'' = f(t, r, 0) - K (q - r) - C q', with K and C at rest coordinates r.
/// Everything else is as in `base`, which must outlive it. Linearising a linear problem changes
/// nothing.
class LinearProblem final : public DerivedProblem {
 public:
  explicit LinearProblem(const Problem& base);

  [[nodiscard]] const Problem& base() const { return *base_; }
  [[nodiscard]] const Eigen::VectorXd& rest() const { return rest_; }
  [[nodiscard]] const JacobianMatrix& stiffness() const { return stiffness_; }
  [[nodiscard]] const Eigen::SparseMatrix<double>& damping() const { return damping_; }

  void force(double t, double gate, const Coordinates& q, const Coordinates& v,
             Eigen::Ref<Eigen::VectorXd> f) const override;
  void jacobian(const Coordinates& q, const Coordinates& v, JacobianMatrix& stiffness,
                Eigen::SparseMatrix<double>& damping) const override;
  /// Returns kinetic energy + (q - r)^T K (q - r) / 2 - f_0^T (q - r) [J], with f_0 the force at
  /// rest without loads.
  [[nodiscard]] double energy(const Coordinates& q, const Coordinates& v) const override;

 private:
  Eigen::VectorXd rest_;
  Eigen::VectorXd still_;  ///< vector of zero velocity
  Eigen::VectorXd unloaded_force_;
  Eigen::SparseMatrix<double> stiffness_;
  Eigen::SparseMatrix<double> damping_;
};

/// Load of known shape: its force is `amplitude` times 1, (t - start) / (end - start), sin(pi (t -
/// start) / (end - start)), or cos(frequency t), for activation times in [start, end).
struct ShapedLoad {
  enum class Shape { constant, ramp, half_sine, cosine } shape = Shape::constant;
  Eigen::VectorXd amplitude{};  ///< [N] per coordinate
  double start = 0.0;           ///< [s]
  double end = 0.0;             ///< [s]
  double frequency = 0.0;       ///< [rad/s], cosine only
};

/// Returns all forces on `problem` except springs and dampers: loads, weight, force at rest. Throws
/// SolverError if the loads of this kind of problem have no known closed form.
std::vector<ShapedLoad> shaped_loads(const LinearProblem& problem);

// Problem with a chosen exact solution (method of manufactured solutions): the additional force M
// q*'' - f(t, q*, q*') makes any Problem move along q*, with every spring active.

/// Manufactured motion q*_i(t) = q_i(0) + A_i (1 + s^2 (3 - 2 s)) sin(w_i t + phi_i), s = t /
/// duration. A_i, w_i and phi_i vary between coordinates around these values.
struct ManufacturedMotion {
  double amplitude = 1e-3;   ///< [m]
  double frequency = 100.0;  ///< [rad/s]
  double duration = 0.1;     ///< [s]
};

class ManufacturedProblem final : public DerivedProblem {
 public:
  /// The loads of `base` cancel.
  ManufacturedProblem(const Problem& base, const ManufacturedMotion& motion);

  [[nodiscard]] Eigen::VectorXd exact_position(double t) const;      ///< q*(t) [m]
  [[nodiscard]] Eigen::VectorXd exact_velocity(double t) const;      ///< [m/s]
  [[nodiscard]] Eigen::VectorXd exact_acceleration(double t) const;  ///< [m/s^2]

  [[nodiscard]] Eigen::VectorXd initial_position() const override { return exact_position(0.0); }
  [[nodiscard]] Eigen::VectorXd initial_velocity() const override { return exact_velocity(0.0); }
  void force(double t, double gate, const Coordinates& q, const Coordinates& v,
             Eigen::Ref<Eigen::VectorXd> f) const override;
  [[nodiscard]] double shortest_feature() const override;

 private:
  ManufacturedMotion motion_;
  Eigen::ArrayXd origin_;     ///< [m]
  Eigen::ArrayXd amplitude_;  ///< [m]
  Eigen::ArrayXd frequency_;  ///< [rad/s]
  Eigen::ArrayXd phase_;      ///< [rad]
};

}  // namespace palpate::reference
