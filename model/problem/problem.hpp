// SPDX-License-Identifier: MIT
#pragma once
/// Equation of motion of a scene, M q'' = f(t, q, q'). It is the executable specification and is
/// not optimised: reference solvers integrate it, and the tests compare every kernel with it. It
/// does not depend on the time integration.

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "model/problem/scene.hpp"
#include "model/problem/spring_law.hpp"

namespace Eigen {
template <typename Scalar, int Options, typename StorageIndex> class SparseMatrix;
}

namespace palpate {

using JacobianMatrix = Eigen::SparseMatrix<double, 0, int>;  ///< of <Eigen/SparseCore>
using Coordinates = Eigen::Ref<const Eigen::VectorXd>;       ///< positions or velocities

/// Equation of motion, smooth between the breaks at which loads switch. The activation time `gate`
/// determines the active loads: an integrator passes the beginning of its step, a reference solver
/// any time strictly between two breaks.
class Problem {
 public:
  virtual ~Problem() = default;
  [[nodiscard]] virtual Eigen::Index dof() const = 0;
  [[nodiscard]] virtual const Eigen::VectorXd& mass() const = 0;  ///< per coordinate [kg]
  [[nodiscard]] virtual Eigen::VectorXd initial_position() const = 0;
  [[nodiscard]] virtual Eigen::VectorXd initial_velocity() const = 0;
  /// Computes the total force per coordinate [N]; q [m], v [m/s]. Relaxing tissue has its
  /// instantaneous stiffness here: its state is not in q and v.
  virtual void force(double t, double gate, const Coordinates& q, const Coordinates& v,
                     Eigen::Ref<Eigen::VectorXd> f) const = 0;
  /// Computes the exact K = -df/dq and C = -df/dv. The sparsity pattern is the same on every call.
  virtual void jacobian(const Coordinates& q, const Coordinates& v, JacobianMatrix& stiffness,
                        JacobianMatrix& damping) const = 0;
  /// Returns the times at which a load begins or ends [s], sorted and without duplicates.
  [[nodiscard]] virtual std::vector<double> breaks() const = 0;
  /// Returns the shortest time over which a load changes [s]; infinite if all loads are constant.
  [[nodiscard]] virtual double shortest_feature() const = 0;
  /// Returns the sum of kinetic energy, elastic energy and potential energy of gravity [J].
  [[nodiscard]] virtual double energy(const Coordinates& q, const Coordinates& v) const = 0;
};

/// Returns a load's profile at time t if `gate` is in [start, end), otherwise 0.
double load_factor(const Load& load, double t, double gate) noexcept;

/// Derivatives of the force on end a of a spring by d = x_b - x_a and w = v_b - v_a; zero for a
/// spring of zero length.
template <class Real> struct SpringGradient {
  Eigen::Matrix<Real, 3, 3> position = Eigen::Matrix<Real, 3, 3>::Zero();
  Eigen::Matrix<Real, 3, 3> velocity = Eigen::Matrix<Real, 3, 3>::Zero();
};

/// `pull`: elastic part of a spring that stiffens or relaxes, in place of the linear one.
template <class Real>
SpringGradient<Real> spring_gradient(const SpringLaw& law, const SpringNumbers<Real>& numbers,
                                     const Eigen::Matrix<Real, 3, 1>& d,
                                     const Eigen::Matrix<Real, 3, 1>& w,
                                     const ElasticPull* pull = nullptr) noexcept {
  using Matrix = Eigen::Matrix<Real, 3, 3>;
  using Vector3 = Eigen::Matrix<Real, 3, 1>;
  const Real length = d.norm();
  if (!(length > static_cast<Real>(zero_length))) { return {}; }
  SpringNumbers<Real> spring = law.with_signs(numbers);
  spring.stiffness *= static_cast<Real>(law.scale);
  spring.viscosity *= static_cast<Real>(law.scale);
  const Vector3 u = d / length;
  const Real rate = w.dot(u);
  Real tension = SpringTension<>::of(spring, length, rate);
  if (pull != nullptr) {
    spring.stiffness = static_cast<Real>(pull->stiffness);
    tension = static_cast<Real>(pull->tension) + spring.viscosity * rate;
  }
  const Vector3 slope = spring.stiffness * u + (spring.viscosity / length) * (w - rate * u);
  const Vector3 e = law.along_displacement ? d : u;
  const Matrix turn = law.along_displacement
                          ? Matrix(Matrix::Identity())
                          : Matrix((Matrix::Identity() - u * u.transpose()) / length);
  return {e * slope.transpose() + tension * turn, spring.viscosity * e * u.transpose()};
}

/// Equation of motion of a network. The coordinates are those of the free nodes in node order.
/// Errata of the time step (no_time_step, lagged_velocity) are ignored.
class NetworkProblem final : public Problem {
 public:
  /// Builds the problem. `loads` must refer to nodes; resolve_loads() replaces faces.
  NetworkProblem(SpringNetwork network, std::vector<Load> loads = {},
                 const Eigen::Vector3d& gravity = Eigen::Vector3d::Zero(),
                 const PrintedForm& printed = {});

  [[nodiscard]] Eigen::Index dof() const override {
    return 3 * static_cast<Eigen::Index>(free_.size());
  }
  [[nodiscard]] const Eigen::VectorXd& mass() const override { return mass_; }
  [[nodiscard]] Eigen::VectorXd initial_position() const override;
  [[nodiscard]] Eigen::VectorXd initial_velocity() const override;
  void force(double t, double gate, const Coordinates& q, const Coordinates& v,
             Eigen::Ref<Eigen::VectorXd> f) const override;
  void jacobian(const Coordinates& q, const Coordinates& v, JacobianMatrix& stiffness,
                JacobianMatrix& damping) const override;
  [[nodiscard]] std::vector<double> breaks() const override;
  [[nodiscard]] double shortest_feature() const override;
  [[nodiscard]] double energy(const Coordinates& q, const Coordinates& v) const override;

  [[nodiscard]] const SpringNetwork& network() const { return network_; }
  [[nodiscard]] const std::vector<Load>& loads() const { return loads_; }
  [[nodiscard]] const Eigen::Vector3d& gravity() const { return gravity_; }
  [[nodiscard]] const std::vector<int>& free_nodes() const { return free_; }  ///< ascending
  /// Returns the initial positions of all nodes; fixed nodes keep them.
  [[nodiscard]] const NodeVectors& held_position() const {
    return network_.initial_displacement.cols() == 0 ? network_.rest_position : displaced_;
  }
  [[nodiscard]] std::size_t memory_bytes() const;
  /// Returns the first coordinate of a node, or -1 for a fixed node.
  [[nodiscard]] Eigen::Index coordinate(int node) const {
    return coordinate_[static_cast<std::size_t>(node)];
  }

 private:
  /// Calls visit(spring, a, b, d, w) for each spring, with the first coordinates of its ends, -1 if
  /// fixed, d = x_b - x_a and w = v_b - v_a.
  template <class Visit>
  void for_each_spring(const Coordinates& q, const Coordinates& v, Visit visit) const;
  /// Calls visit(cell, x, v) for each cell, with the positions and velocities of its corners.
  template <class Visit>
  void for_each_cell(const Coordinates& q, const Coordinates& v, Visit visit) const;

  SpringNetwork network_;
  std::vector<Load> loads_;
  Eigen::Vector3d gravity_;
  PrintedForm printed_;
  NodeVectors displaced_;  ///< initial positions, if they differ from the rest positions
  std::vector<int> free_;
  std::vector<int> coordinate_;
  Eigen::VectorXd mass_;
};

/// State of the cells of a network: of a regular lattice, or those that resist changes of volume.
struct CellCheck {
  double smallest = 1.0;  ///< smallest corner Jacobian: volume of a corner relative to rest [1]
  long inverted = 0;      ///< cells with a corner that is flat or inside out
};
/// Checks the cells at the positions of all nodes [m], 3 x nodes.
CellCheck check_cells(const SpringNetwork& network, const Eigen::Ref<const NodeVectors>& position);

/// Returns the corner nodes of these cells; bit n of a corner's index is its side along axis n.
std::vector<std::array<int, 8>> cell_corners(const SpringNetwork& network);

/// Oscillator of Eqs. 3-5: one coordinate, driven by F0 cos(W t).
class OscillatorProblem final : public Problem {
 public:
  explicit OscillatorProblem(const Oscillator& oscillator);
  [[nodiscard]] Eigen::Index dof() const override { return 1; }
  [[nodiscard]] const Eigen::VectorXd& mass() const override { return mass_; }
  [[nodiscard]] Eigen::VectorXd initial_position() const override;
  [[nodiscard]] Eigen::VectorXd initial_velocity() const override;
  void force(double t, double gate, const Coordinates& q, const Coordinates& v,
             Eigen::Ref<Eigen::VectorXd> f) const override;
  void jacobian(const Coordinates& q, const Coordinates& v, JacobianMatrix& stiffness,
                JacobianMatrix& damping) const override;
  [[nodiscard]] std::vector<double> breaks() const override { return {}; }
  [[nodiscard]] double shortest_feature() const override;
  [[nodiscard]] double energy(const Coordinates& q, const Coordinates& v) const override;
  [[nodiscard]] const Oscillator& oscillator() const { return oscillator_; }

 private:
  Oscillator oscillator_;
  Eigen::VectorXd mass_;
};

/// Builds the equation of motion of a scene; defined with the network builders in model/tissue.
std::unique_ptr<Problem> make_problem(const Scene& scene);

}  // namespace palpate
