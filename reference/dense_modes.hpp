// SPDX-License-Identifier: MIT
#pragma once
/// Eigenvalues of small dense symmetric matrices, compiled once for all who ask.

#include <Eigen/Core>

namespace palpate::reference {

struct SymmetricModes {
  Eigen::VectorXd values{};   ///< ascending
  Eigen::MatrixXd vectors{};  ///< one column each, orthonormal
};

/// Of a symmetric matrix; only its lower half is read.
SymmetricModes symmetric_modes(const Eigen::MatrixXd& matrix);
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& matrix);

}  // namespace palpate::reference
