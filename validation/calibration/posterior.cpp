// SPDX-License-Identifier: MIT
#include "validation/calibration/posterior.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace palpate::calibration {

namespace {

/// The weighted slopes w J, and H^-1.
struct Normal {
  Eigen::MatrixXd weighted{};
  Eigen::MatrixXd inverse{};
};

Normal normal_equations(const Linearised& at) {
  const Eigen::Index count = at.slope.cols();
  const Eigen::MatrixXd weighted = at.covariance.diagonal().cwiseInverse().asDiagonal() * at.slope;
  const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(count, count);
  const Eigen::LLT<Eigen::MatrixXd> information(at.slope.transpose() * weighted + unit);
  return {.weighted = weighted, .inverse = information.solve(unit)};
}

}  // namespace

Eigen::MatrixXd posterior_covariance(const Linearised& at) {
  const Normal normal = normal_equations(at);
  const Eigen::MatrixXd spread = at.covariance + at.considered * at.considered.transpose();
  return passed_on(at, spread) + normal.inverse * normal.inverse;
}

Eigen::MatrixXd passed_on(const Linearised& at, const Eigen::MatrixXd& part) {
  const Normal normal = normal_equations(at);
  return normal.inverse * normal.weighted.transpose() * part * normal.weighted * normal.inverse;
}

Eigen::MatrixXd correlation_of(const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
  return scale.asDiagonal() * covariance * scale.asDiagonal();
}

std::vector<Eigen::Index> told_columns(const Eigen::MatrixXd& slope, const Eigen::MatrixXd& covariance,
                                       std::vector<Eigen::Index> candidates) {
  constexpr double most_left = 0.5;  // of the prior variance
  std::vector<Eigen::Index> told = std::move(candidates);
  while (!told.empty()) {
    const Eigen::VectorXd left = posterior_covariance({.slope = columns_of(slope, told),
                                                       .considered = columns_besides(slope, told),
                                                       .covariance = covariance})
                                     .diagonal();
    Eigen::Index worst = 0;
    if (left.maxCoeff(&worst) < most_left) { break; }
    told.erase(told.begin() + worst);
  }
  return told;
}

Eigen::MatrixXd columns_of(const Eigen::MatrixXd& matrix, const std::vector<Eigen::Index>& columns) {
  Eigen::MatrixXd chosen(matrix.rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t n = 0; n < columns.size(); ++n) {
    chosen.col(static_cast<Eigen::Index>(n)) = matrix.col(columns[n]);
  }
  return chosen;
}

Eigen::MatrixXd columns_besides(const Eigen::MatrixXd& matrix, const std::vector<Eigen::Index>& columns) {
  std::vector<Eigen::Index> others;
  for (Eigen::Index c = 0; c < matrix.cols(); ++c) {
    if (std::ranges::find(columns, c) == columns.end()) { others.push_back(c); }
  }
  return columns_of(matrix, others);
}

}  // namespace palpate::calibration
