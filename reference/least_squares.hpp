// SPDX-License-Identifier: MIT
#pragma once
/// Nonlinear least squares by GSL's trust region (Levenberg-Marquardt, scaling by J. J. Moré 1978).

#include <Eigen/Core>
#include <functional>

namespace palpate::reference {

/// Problem that minimises half the sum of squared residuals; residuals are in units of their
/// uncertainty.
struct LeastSquaresProblem {
  std::function<Eigen::VectorXd(const Eigen::VectorXd&)> residuals{};  ///< same size for every x
  std::function<Eigen::MatrixXd(const Eigen::VectorXd&)> jacobian{};   ///< residuals x parameters
};

struct LeastSquaresRule {
  std::size_t most_iterations = 30;
  double step_tolerance = 1e-4;      ///< of x, relative (and absolute near 0)
  double gradient_tolerance = 1e-6;  ///< of the gradient, relative to the sum of squares
};

struct LeastSquaresSolution {
  Eigen::VectorXd x{};
  Eigen::VectorXd residuals{};
  std::size_t iterations = 0;
  bool converged = false;
  [[nodiscard]] double cost() const { return residuals.squaredNorm(); }  ///< the sum of squares
};

/// Solves a least-squares problem with at least as many residuals as parameters. Exceptions of its
/// functions are rethrown unchanged.
LeastSquaresSolution least_squares(const LeastSquaresProblem& problem, const Eigen::VectorXd& start,
                                   const LeastSquaresRule& rule = {});

}  // namespace palpate::reference
