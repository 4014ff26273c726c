// SPDX-License-Identifier: MIT
#pragma once
/// What is known of parameters after a fit, from its linearisation alone. Parameters are
/// standardised, so the prior of each has variance 1.

#include <Eigen/Core>
#include <vector>

namespace palpate::calibration {

/// Around the place of the fit, one row per observable that is there.
struct Linearised {
  Eigen::MatrixXd slope{};       ///< J, of the parameters that are fitted
  Eigen::MatrixXd considered{};  ///< J of those left at their prior, whose uncertainty stays
  Eigen::MatrixXd covariance{};  ///< C of the means that were fitted, in full
};

/// The fit weighs rows by their own variances, w = 1 / C_ii, and so is x = G (y - f) with
/// G = H^-1 J^T w, H = J^T w J + 1. What it passes on is
///   G (C + J_c J_c^T) G^T + H^-2
/// of correlated rows, of the parameters that were left, and of the prior ("consider covariance",
/// Schmidt 1966; sandwich of Huber 1967).
Eigen::MatrixXd posterior_covariance(const Linearised& at);

/// G c G^T: what one part c of the rows' covariance passes on.
Eigen::MatrixXd passed_on(const Linearised& at, const Eigen::MatrixXd& part);

Eigen::MatrixXd correlation_of(const Eigen::MatrixXd& covariance);

/// Those of `candidates` (columns of `slope`) that data tell: fitted without the others, each has less than
/// half of its prior variance, so that data say more than the prior. The worst are left one by one.
std::vector<Eigen::Index> told_columns(const Eigen::MatrixXd& slope, const Eigen::MatrixXd& covariance,
                                       std::vector<Eigen::Index> candidates);

/// The columns of a matrix in this order, and those that are left.
Eigen::MatrixXd columns_of(const Eigen::MatrixXd& matrix, const std::vector<Eigen::Index>& columns);
Eigen::MatrixXd columns_besides(const Eigen::MatrixXd& matrix, const std::vector<Eigen::Index>& columns);

}  // namespace palpate::calibration
