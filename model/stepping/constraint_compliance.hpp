// SPDX-License-Identifier: MIT
#pragma once
/// What a tool holds, inside a preconditioner: corrects x = P^-1 r so that x moves the held knots
/// as r alone would through their masses (model/EQUATIONS.md, "Held constraints"). Then the
/// preconditioner knows the constraints and the linear solve does not have to find them.

#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

#include "model/kernels/system.hpp"

namespace palpate {

template <class Real> class ConstraintCompliance {
 public:
  /// A free node under a knot.
  struct Support {
    Eigen::Index coordinate;
    double weight;
    double inverse_mass;
  };
  using Solve = std::function<void(const Vector<Real>& right, Vector<Real>& solution)>;

  /// `begin[k]` to `begin[k + 1]` are the supports of knot k. `tool` is the tool's coordinate, or
  /// -1. Asks `solve` for P^-1 once per knot and axis; allocates.
  void learn(std::vector<Support> supports, std::vector<std::size_t> begin, Eigen::Index tool,
             double tool_mass, Eigen::Index dof, const Solve& solve);
  [[nodiscard]] bool learned() const { return dof_ > 0; }

  /// Rows of what is held: sum over knots of coefficient.U plus `on_tool` times the tool's own.
  void clear() noexcept { rows_ = 0; }
  /// One row; the coefficients of knots [first, first + count) are to be filled in.
  std::span<Eigen::Vector3d> add_row(std::size_t first, std::size_t count, double on_tool) noexcept;
  /// After the last row.
  void factorise() noexcept;
  void correct(const Vector<Real>& r, Vector<Real>& x) const noexcept;
  /// n.U of two neighbouring knots together under a unit impulse along n, shared between them,
  /// nothing held: w P^-1 w^T [1/kg].
  [[nodiscard]] double response_at(std::size_t knot, double share,
                                   const Eigen::Vector3d& n) const noexcept;
  /// W P^-1 W^T of row i, others not held [1/kg].
  [[nodiscard]] double response_of(std::size_t i) const noexcept {
    const auto row = static_cast<Eigen::Index>(i);
    return small_.row(row).head(row + 1).squaredNorm();
  }

 private:
  struct Row {
    std::size_t first = 0;
    std::size_t count = 0;
    double on_tool = 0.0;
    std::size_t coefficients = 0;  ///< where they begin
  };
  [[nodiscard]] double along(const Row& row, const Eigen::Ref<const Eigen::VectorXd>& knots,
                             double tool) const noexcept;

  std::vector<Support> supports_{};
  std::vector<std::size_t> begin_{};
  Eigen::Index tool_ = -1;
  double tool_mass_ = 0.0;
  Eigen::Index dof_ = 0;
  Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic> response_{};  ///< P^-1 of each direction
  Eigen::MatrixXd gram_{};                                          ///< 3 knots x 3 knots
  double tool_response_ = 0.0;  ///< of the tool's own coordinate, which no spring touches

  std::vector<Row> row_{};
  std::vector<Eigen::Vector3d> coefficients_{};
  std::size_t rows_ = 0;
  std::size_t used_ = 0;
  Eigen::MatrixXd image_{};  ///< gram times the rows
  Eigen::MatrixXd small_{};  ///< of the rows, then its Cholesky factor
  mutable Eigen::VectorXd knots_{};
  mutable Eigen::VectorXd inertial_{};
  mutable Vector<Real> shares_{};  ///< of the directions in the correction
  mutable Eigen::VectorXd multipliers_{};
};

}  // namespace palpate
