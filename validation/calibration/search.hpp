// SPDX-License-Identifier: MIT
#pragma once
/// The least squares problem behind a fit: some parameters free, the others held, priors as rows.

#include "reference/least_squares.hpp"
#include "validation/calibration/forward.hpp"
#include "validation/calibration/pooled.hpp"

namespace palpate::calibration {

class Search {
 public:
  /// `free` are indices of the forward model's parameters.
  Search(Forward& forward, const Pooled& data, std::vector<std::size_t> free);

  struct Found {
    Forward::Values values{};
    double cost = 0.0;  ///< sum of squares, rows and priors
    std::size_t iterations = 0;
    bool converged = false;
  };
  /// From these values; those that are not free stay as they are.
  Found from(const Forward::Values& start, const reference::LeastSquaresRule& rule = {}) const;

  /// Standardised slopes d f / d x of these parameters, one column each, rows of the data.
  [[nodiscard]] Eigen::MatrixXd slopes(const Forward::Values& at, const std::vector<std::size_t>& of) const;
  [[nodiscard]] Eigen::VectorXd rows_of(const Observation& observation) const;
  [[nodiscard]] const std::vector<Eigen::Index>& rows() const { return rows_; }
  [[nodiscard]] Eigen::MatrixXd covariance() const { return rows_of(data_.covariance); }
  [[nodiscard]] Eigen::MatrixXd rows_of(const Eigen::MatrixXd& covariance) const;
  /// (simulated - seen) over the standard uncertainty of each row.
  [[nodiscard]] Eigen::VectorXd misfits(const Observation& simulated) const;

 private:
  [[nodiscard]] Forward::Values values_at(const Forward::Values& base, const Eigen::VectorXd& q) const;
  [[nodiscard]] Eigen::VectorXd residuals(const Forward::Values& at) const;
  [[nodiscard]] Eigen::MatrixXd jacobian(const Forward::Values& at, const Eigen::VectorXd& q) const;

  Forward& forward_;
  const Pooled& data_;
  std::vector<std::size_t> free_;
  std::vector<Eigen::Index> rows_{};
  Eigen::VectorXd deviation_{};  ///< standard uncertainty of each row
};

}  // namespace palpate::calibration
