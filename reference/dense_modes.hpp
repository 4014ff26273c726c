// SPDX-License-Identifier: MIT
#pragma once
/// Eigenvalues of small dense matrices, by GSL. Throw SolverError where it does not converge.

#include <Eigen/Core>

namespace palpate::reference {

struct SymmetricModes {
  Eigen::VectorXd values{};   ///< ascending
  Eigen::MatrixXd vectors{};  ///< one column each, orthonormal
};

/// Of a symmetric matrix; only its lower half is read.
SymmetricModes symmetric_modes(const Eigen::MatrixXd& matrix);
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& matrix);

struct GeneralModes {
  Eigen::VectorXcd values{};   ///< in no order
  Eigen::MatrixXcd vectors{};  ///< one column each, of length one
};

/// Of any real matrix.
GeneralModes general_modes(const Eigen::MatrixXd& matrix);

}  // namespace palpate::reference
