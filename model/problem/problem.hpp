// SPDX-License-Identifier: MIT
#pragma once
/// Equation of motion of a scene, M q'' = f(t, q, q'): its executable specification, plain and slow
/// on purpose. References integrate it; every fast kernel has a test that compares it with this.
/// Nothing here depends on how a step is taken.

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "model/problem/scene.hpp"
#include "model/problem/spring_law.hpp"

namespace palpate {

/// Loads switch at breaks, so f is smooth only between them. `gate` is the instant that decides
/// which loads are on: a stepping scheme passes the beginning of its step, a reference any time
/// strictly inside the segment between two breaks that it integrates.
class Problem {
 public:
  virtual ~Problem() = default;
  [[nodiscard]] virtual Eigen::Index dof() const = 0;
  [[nodiscard]] virtual const Eigen::VectorXd& mass() const = 0;  ///< [kg] per coordinate
  [[nodiscard]] virtual Eigen::VectorXd initial_position() const = 0;
  [[nodiscard]] virtual Eigen::VectorXd initial_velocity() const = 0;
  /// Total force [N] per coordinate; q [m], v [m/s].
  virtual void force(double t, double gate, const Eigen::Ref<const Eigen::VectorXd>& q,
                     const Eigen::Ref<const Eigen::VectorXd>& v,
                     Eigen::Ref<Eigen::VectorXd> f) const = 0;
  /// K = -df/dq and C = -df/dv, complete and exact; both have the same pattern on every call.
  virtual void jacobian(const Eigen::Ref<const Eigen::VectorXd>& q,
                        const Eigen::Ref<const Eigen::VectorXd>& v,
                        Eigen::SparseMatrix<double>& stiffness,
                        Eigen::SparseMatrix<double>& damping) const = 0;
  /// Instants where a load begins or ends [s], sorted, without duplicates.
  [[nodiscard]] virtual std::vector<double> breaks() const = 0;
  /// Shortest time over which a load changes [s] (infinite when all are constant).
  [[nodiscard]] virtual double shortest_feature() const = 0;
  /// Kinetic plus elastic energy, plus the potential of gravity [J].
  [[nodiscard]] virtual double energy(const Eigen::Ref<const Eigen::VectorXd>& q,
                                      const Eigen::Ref<const Eigen::VectorXd>& v) const = 0;
};

/// Factor of a load's force at time t: its profile where `gate` lies in [start, end), else 0.
double load_factor(const Load& load, double t, double gate) noexcept;

/// Derivatives of the force on end a of a spring with respect to d = x_b - x_a and to the relative
/// velocity w = v_b - v_a; zero for a spring without direction.
template <class Real> struct SpringGradient {
  Eigen::Matrix<Real, 3, 3> position = Eigen::Matrix<Real, 3, 3>::Zero();
  Eigen::Matrix<Real, 3, 3> velocity = Eigen::Matrix<Real, 3, 3>::Zero();
};

template <class Real>
SpringGradient<Real> spring_gradient(const SpringLaw& law, const SpringNumbers<Real>& numbers,
                                     const Eigen::Matrix<Real, 3, 1>& d,
                                     const Eigen::Matrix<Real, 3, 1>& w) noexcept {
  using Matrix = Eigen::Matrix<Real, 3, 3>;
  using Vector3 = Eigen::Matrix<Real, 3, 1>;
  const Real length = d.norm();
  if (!(length > static_cast<Real>(zero_length))) { return {}; }
  SpringNumbers<Real> spring = law.with_signs(numbers);
  spring.stiffness *= static_cast<Real>(law.scale);
  spring.viscosity *= static_cast<Real>(law.scale);
  const Vector3 u = d / length;
  const Real rate = w.dot(u);
  const Real tension = SpringTension<>::of(spring, length, rate);
  const Vector3 slope = spring.stiffness * u + (spring.viscosity / length) * (w - rate * u);
  const Vector3 e = law.along_displacement ? d : u;
  const Matrix turn = law.along_displacement
                          ? Matrix(Matrix::Identity())
                          : Matrix((Matrix::Identity() - u * u.transpose()) / length);
  return {e * slope.transpose() + tension * turn, spring.viscosity * e * u.transpose()};
}

/// Coordinates of the free nodes, three each, in node order. Errata of the force law are honoured;
/// those of the stepping (no_time_step, lagged_velocity) have no meaning here.
class NetworkProblem final : public Problem {
 public:
  /// `loads` name nodes (faces are resolved by resolve_loads()).
  NetworkProblem(SpringNetwork network, std::vector<Load> loads = {},
                 const Eigen::Vector3d& gravity = Eigen::Vector3d::Zero(),
                 const PrintedForm& printed = {});

  [[nodiscard]] Eigen::Index dof() const override {
    return 3 * static_cast<Eigen::Index>(free_.size());
  }
  [[nodiscard]] const Eigen::VectorXd& mass() const override { return mass_; }
  [[nodiscard]] Eigen::VectorXd initial_position() const override;
  [[nodiscard]] Eigen::VectorXd initial_velocity() const override;
  void force(double t, double gate, const Eigen::Ref<const Eigen::VectorXd>& q,
             const Eigen::Ref<const Eigen::VectorXd>& v,
             Eigen::Ref<Eigen::VectorXd> f) const override;
  void jacobian(const Eigen::Ref<const Eigen::VectorXd>& q,
                const Eigen::Ref<const Eigen::VectorXd>& v, Eigen::SparseMatrix<double>& stiffness,
                Eigen::SparseMatrix<double>& damping) const override;
  [[nodiscard]] std::vector<double> breaks() const override;
  [[nodiscard]] double shortest_feature() const override;
  [[nodiscard]] double energy(const Eigen::Ref<const Eigen::VectorXd>& q,
                              const Eigen::Ref<const Eigen::VectorXd>& v) const override;

  [[nodiscard]] const SpringNetwork& network() const { return network_; }
  [[nodiscard]] const std::vector<Load>& loads() const { return loads_; }
  [[nodiscard]] const Eigen::Vector3d& gravity() const { return gravity_; }
  [[nodiscard]] const std::vector<int>& free_nodes() const { return free_; }  ///< ascending
  /// Initial positions of all nodes: where fixed ones stay.
  [[nodiscard]] const NodeVectors& held_position() const {
    return network_.initial_displacement.cols() == 0 ? network_.rest_position : displaced_;
  }
  [[nodiscard]] std::size_t memory_bytes() const;
  /// First coordinate of a node, or -1 when it is fixed.
  [[nodiscard]] Eigen::Index coordinate(int node) const {
    return coordinate_[static_cast<std::size_t>(node)];
  }

 private:
  SpringNetwork network_;
  std::vector<Load> loads_;
  Eigen::Vector3d gravity_;
  PrintedForm printed_;
  NodeVectors displaced_;  ///< initial positions, where they are not those at rest
  std::vector<int> free_;
  std::vector<Eigen::Index> coordinate_;
  Eigen::VectorXd mass_;
};

/// Eqs. 3-5: one coordinate, driven by F0 cos(W t).
class OscillatorProblem final : public Problem {
 public:
  explicit OscillatorProblem(const Oscillator& oscillator);
  [[nodiscard]] Eigen::Index dof() const override { return 1; }
  [[nodiscard]] const Eigen::VectorXd& mass() const override { return mass_; }
  [[nodiscard]] Eigen::VectorXd initial_position() const override;
  [[nodiscard]] Eigen::VectorXd initial_velocity() const override;
  void force(double t, double gate, const Eigen::Ref<const Eigen::VectorXd>& q,
             const Eigen::Ref<const Eigen::VectorXd>& v,
             Eigen::Ref<Eigen::VectorXd> f) const override;
  void jacobian(const Eigen::Ref<const Eigen::VectorXd>& q,
                const Eigen::Ref<const Eigen::VectorXd>& v, Eigen::SparseMatrix<double>& stiffness,
                Eigen::SparseMatrix<double>& damping) const override;
  [[nodiscard]] std::vector<double> breaks() const override { return {}; }
  [[nodiscard]] double shortest_feature() const override;
  [[nodiscard]] double energy(const Eigen::Ref<const Eigen::VectorXd>& q,
                              const Eigen::Ref<const Eigen::VectorXd>& v) const override;
  [[nodiscard]] const Oscillator& oscillator() const { return oscillator_; }

 private:
  Oscillator oscillator_;
  Eigen::VectorXd mass_;
};

/// The scene as an equation of motion; defined with the builders of networks in model/tissue.
std::unique_ptr<Problem> make_problem(const Scene& scene);

}  // namespace palpate
