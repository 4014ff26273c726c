// SPDX-License-Identifier: MIT
#pragma once
/// Compliance of the active contact constraints for a preconditioner P. Corrects x = P^-1 r so that
/// the constrained contact points move as r alone moves their masses (model/EQUATIONS.md, "Held
/// constraints"). The linear solver then needs no iterations for the constraints.

#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

#include "model/kernels/system.hpp"

namespace palpate {

template <class Real> class ConstraintCompliance {
 public:
  /// Free node that a contact point interpolates from.
  struct Support {
    Eigen::Index coordinate;
    double weight;
    double inverse_mass;
  };
  using Solve = std::function<void(const Vector<Real>& right, Vector<Real>& solution)>;

  /// Computes P^-1 for each contact point and axis; calls `solve` once for each and allocates. The
  /// supports of contact point k are `begin[k]` to `begin[k + 1]`. `tool` is the tool's coordinate,
  /// or -1.
  void learn(std::vector<Support> supports, std::vector<std::size_t> begin, Eigen::Index tool,
             double tool_mass, Eigen::Index dof, const Solve& solve);
  [[nodiscard]] bool learned() const { return dof_ > 0; }

  /// Removes all constraint rows. A row is the sum over contact points of coefficient . U, plus
  /// `on_tool` times the tool's coordinate.
  void clear() noexcept { rows_ = 0; }
  /// Adds a row and returns the coefficients of contact points [first, first + count), which the
  /// caller must set.
  std::span<Eigen::Vector3d> add_row(std::size_t first, std::size_t count, double on_tool) noexcept;
  /// Factorises the constraint matrix; call it after the last row.
  void factorise() noexcept;
  void correct(const Vector<Real>& r, Vector<Real>& x) const noexcept;
  /// Returns w P^-1 w^T [1/kg]: the response along n of two neighbouring contact points to a unit
  /// impulse along n that is divided between them, without constraints.
  [[nodiscard]] double response_at(std::size_t knot, double share,
                                   const Eigen::Vector3d& n) const noexcept;
  /// Returns W P^-1 W^T of row i without the other constraints [1/kg].
  [[nodiscard]] double response_of(std::size_t i) const noexcept {
    const auto row = static_cast<Eigen::Index>(i);
    return small_.row(row).head(row + 1).squaredNorm();
  }

 private:
  struct Row {
    std::size_t first = 0;
    std::size_t count = 0;
    double on_tool = 0.0;
    std::size_t coefficients = 0;  ///< index of the first coefficient
  };
  [[nodiscard]] double along(const Row& row, const Eigen::Ref<const Eigen::VectorXd>& knots,
                             double tool) const noexcept;

  std::vector<Support> supports_{};
  std::vector<std::size_t> begin_{};
  Eigen::Index tool_ = -1;
  double tool_mass_ = 0.0;
  Eigen::Index dof_ = 0;
  Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic> response_{};  ///< P^-1 of each direction
  Eigen::MatrixXd gram_{};      ///< 3 contact points x 3 contact points
  double tool_response_ = 0.0;  ///< P^-1 of the tool's coordinate, on which no spring acts

  std::vector<Row> row_{};
  std::vector<Eigen::Vector3d> coefficients_{};
  std::size_t rows_ = 0;
  std::size_t used_ = 0;
  Eigen::MatrixXd image_{};  ///< gram times the rows
  Eigen::MatrixXd small_{};  ///< matrix of the rows, then its Cholesky factor
  mutable Eigen::VectorXd knots_{};
  mutable Eigen::VectorXd inertial_{};
  mutable Vector<Real> shares_{};  ///< weights of the directions in the correction
  mutable Eigen::VectorXd multipliers_{};
};

}  // namespace palpate
