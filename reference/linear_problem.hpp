// SPDX-License-Identifier: MIT
#pragma once
/// The linearised scene: an exactly solvable problem of the same family and size.

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "model/dynamics/problem.hpp"

namespace palpate::reference {

/// Rest positions of a network, 0 for the oscillator, the initial position of anything else.
Eigen::VectorXd rest_coordinates(const Problem& problem);

/// M q'' = f(t, r, 0) - K (q - r) - C q', with K and C at rest coordinates r, and everything else
/// as in `base`, which must outlive it. Linearising it again changes nothing.
class LinearProblem final : public Problem {
 public:
  explicit LinearProblem(const Problem& base);

  [[nodiscard]] const Problem& base() const { return *base_; }
  [[nodiscard]] const Eigen::VectorXd& rest() const { return rest_; }
  [[nodiscard]] const Eigen::SparseMatrix<double>& stiffness() const { return stiffness_; }
  [[nodiscard]] const Eigen::SparseMatrix<double>& damping() const { return damping_; }

  [[nodiscard]] Eigen::Index dof() const override { return base_->dof(); }
  [[nodiscard]] const Eigen::VectorXd& mass() const override { return base_->mass(); }
  [[nodiscard]] Eigen::VectorXd initial_position() const override {
    return base_->initial_position();
  }
  [[nodiscard]] Eigen::VectorXd initial_velocity() const override {
    return base_->initial_velocity();
  }
  void force(double t, double gate, const Eigen::Ref<const Eigen::VectorXd>& q,
             const Eigen::Ref<const Eigen::VectorXd>& v,
             Eigen::Ref<Eigen::VectorXd> f) const override;
  void jacobian(const Eigen::Ref<const Eigen::VectorXd>& q,
                const Eigen::Ref<const Eigen::VectorXd>& v, Eigen::SparseMatrix<double>& stiffness,
                Eigen::SparseMatrix<double>& damping) const override;
  [[nodiscard]] std::vector<double> breaks() const override { return base_->breaks(); }
  [[nodiscard]] double shortest_feature() const override { return base_->shortest_feature(); }
  /// Kinetic energy + (q - r)^T K (q - r) / 2 - f_0^T (q - r), f_0 the force at rest without loads.
  [[nodiscard]] double energy(const Eigen::Ref<const Eigen::VectorXd>& q,
                              const Eigen::Ref<const Eigen::VectorXd>& v) const override;

 private:
  const Problem* base_;
  Eigen::VectorXd rest_;
  Eigen::VectorXd still_;  ///< zero velocity
  Eigen::VectorXd unloaded_force_;
  Eigen::SparseMatrix<double> stiffness_;
  Eigen::SparseMatrix<double> damping_;
};

/// A load of known shape: its force is `amplitude` times 1, (t - start) / (end - start),
/// sin(pi (t - start) / (end - start)), or cos(frequency t), for gates in [start, end).
struct ShapedLoad {
  enum class Shape { constant, ramp, half_sine, cosine } shape = Shape::constant;
  Eigen::VectorXd amplitude{};  ///< [N] per coordinate
  double start = 0.0;           ///< [s]
  double end = 0.0;             ///< [s]
  double frequency = 0.0;       ///< [rad/s], cosine only
};

/// All that acts on `problem` besides springs and dampers: loads, weight, force at rest.
/// SolverError for a kind of problem whose loads are not known in closed form.
std::vector<ShapedLoad> shaped_loads(const LinearProblem& problem);

}  // namespace palpate::reference
