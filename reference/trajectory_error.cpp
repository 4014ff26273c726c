// SPDX-License-Identifier: MIT
#include "reference/trajectory_error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace palpate::reference {

using Eigen::MatrixXd;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

void check_sizes(const MatrixXd& candidate, const MatrixXd& reference) {
  if (candidate.rows() != reference.rows() || candidate.cols() != reference.cols() ||
      reference.size() == 0) {
    throw std::invalid_argument("trajectories of different size cannot be compared");
  }
}

}  // namespace

double peak_displacement(const MatrixXd& position) {
  if (!position.allFinite()) { return infinity; }
  return (position.colwise() - position.col(0)).cwiseAbs().maxCoeff();
}

double peak_speed(const MatrixXd& velocity) {
  return velocity.allFinite() ? velocity.cwiseAbs().maxCoeff() : infinity;
}

std::vector<double> instant_errors(const MatrixXd& candidate, const MatrixXd& reference,
                                   double scale) {
  check_sizes(candidate, reference);
  std::vector<double> errors;
  for (Eigen::Index n = 0; n < reference.cols(); ++n) {
    const auto difference = candidate.col(n) - reference.col(n);
    if (!difference.allFinite() || !std::isfinite(scale)) {
      errors.push_back(infinity);
      continue;
    }
    const double largest = difference.cwiseAbs().maxCoeff();
    errors.push_back(largest == 0.0 ? 0.0 : largest / scale);
  }
  return errors;
}

double trajectory_error(const MatrixXd& candidate, const MatrixXd& reference, double scale) {
  return std::ranges::max(instant_errors(candidate, reference, scale));
}

double digits(double error) {
  if (!(error < infinity)) { return 0.0; }
  return std::clamp(-std::log10(error), 0.0, 17.0);
}

double mixed_error_digits(const MatrixXd& candidate, const MatrixXd& reference, double scale) {
  check_sizes(candidate, reference);
  const Eigen::Index last = reference.cols() - 1;
  const auto difference = (candidate.col(last) - reference.col(last)).array().abs();
  const auto size = scale + (reference.col(last) - reference.col(0)).array().abs();
  const Eigen::ArrayXd error = difference / size;
  return error.allFinite() ? digits(error.maxCoeff()) : 0.0;
}

}  // namespace palpate::reference
