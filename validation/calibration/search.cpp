// SPDX-License-Identifier: MIT
#include "validation/calibration/search.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::calibration {
namespace {

/// Of finite differences, in spreads of the prior: far above what the ticks of a simulation leave.
constexpr double difference = 0.1;

/// A free number q stands for log v = lower + (upper - lower) / (1 + exp(-q)).
double share_of(double q) { return 1.0 / (1.0 + std::exp(-q)); }

double from_free(const Parameter& p, double q) {
  return std::exp(std::lerp(std::log(p.lower), std::log(p.upper), share_of(q)));
}

double to_free(const Parameter& p, double value) {
  constexpr double edge = 1e-6;  // a start on a bound would never leave it
  const double share = std::log(value / p.lower) / std::log(p.upper / p.lower);
  const double inside = std::clamp(share, edge, 1.0 - edge);
  return std::log(inside / (1.0 - inside));
}

/// d x / d q of the standardised parameter.
double slope_of_free(const Parameter& p, double q) {
  const double share = share_of(q);
  return std::log(p.upper / p.lower) / p.spread * share * (1.0 - share);
}

}  // namespace

Search::Search(Forward& forward, const Pooled& data, std::vector<std::size_t> free)
    : forward_(forward), data_(data), free_(std::move(free)), rows_(data.present()) {
  deviation_.resize(static_cast<Eigen::Index>(rows_.size()));
  for (std::size_t n = 0; n < rows_.size(); ++n) {
    deviation_[static_cast<Eigen::Index>(n)] = std::sqrt(data.covariance(rows_[n], rows_[n]));
  }
}

Eigen::VectorXd Search::rows_of(const Observation& observation) const {
  Eigen::VectorXd chosen(static_cast<Eigen::Index>(rows_.size()));
  for (std::size_t n = 0; n < rows_.size(); ++n) {
    chosen[static_cast<Eigen::Index>(n)] = observation[rows_[n]];
  }
  return chosen;
}

Eigen::MatrixXd Search::rows_of(const Eigen::MatrixXd& covariance) const {
  const auto count = static_cast<Eigen::Index>(rows_.size());
  Eigen::MatrixXd chosen(count, count);
  for (Eigen::Index r = 0; r < count; ++r) {
    for (Eigen::Index c = 0; c < count; ++c) {
      chosen(r, c) = covariance(rows_[static_cast<std::size_t>(r)], rows_[static_cast<std::size_t>(c)]);
    }
  }
  return chosen;
}

Eigen::VectorXd Search::misfits(const Observation& simulated) const {
  return (rows_of(simulated) - rows_of(data_.mean)).cwiseQuotient(deviation_);
}

Forward::Values Search::values_at(const Forward::Values& base, const Eigen::VectorXd& q) const {
  Forward::Values values = base;
  for (std::size_t n = 0; n < free_.size(); ++n) {
    values[free_[n]] = from_free(forward_.parameters()[free_[n]], q[static_cast<Eigen::Index>(n)]);
  }
  return values;
}

Eigen::VectorXd Search::residuals(const Forward::Values& at) const {
  const Eigen::VectorXd rows = misfits(forward_.at(at));
  Eigen::VectorXd all(rows.size() + static_cast<Eigen::Index>(free_.size()));
  all.head(rows.size()) = rows;
  for (std::size_t n = 0; n < free_.size(); ++n) {
    all[rows.size() + static_cast<Eigen::Index>(n)] =
        forward_.parameters()[free_[n]].standardised(at[free_[n]]);
  }
  return all;
}

Eigen::MatrixXd Search::slopes(const Forward::Values& at, const std::vector<std::size_t>& of) const {
  std::vector<Forward::Values> places{at};
  std::vector<double> steps;
  for (const std::size_t index : of) {
    const Parameter& p = forward_.parameters()[index];
    const double x = p.standardised(at[index]);
    steps.push_back(x + difference > p.standardised(p.upper) ? -difference : difference);
    places.push_back(at);
    places.back()[index] = p.value(x + steps.back());
  }
  const std::vector<Observation> seen = forward_.at(places);
  Eigen::MatrixXd slope(static_cast<Eigen::Index>(rows_.size()), static_cast<Eigen::Index>(of.size()));
  for (std::size_t n = 0; n < of.size(); ++n) {
    slope.col(static_cast<Eigen::Index>(n)) = (rows_of(seen[n + 1]) - rows_of(seen[0])) / steps[n];
  }
  return slope;
}

Eigen::MatrixXd Search::jacobian(const Forward::Values& at, const Eigen::VectorXd& q) const {
  const auto rows = static_cast<Eigen::Index>(rows_.size());
  const auto count = static_cast<Eigen::Index>(free_.size());
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(rows + count, count);
  all.topRows(rows) = deviation_.cwiseInverse().asDiagonal() * slopes(at, free_);
  all.bottomRows(count).setIdentity();
  for (Eigen::Index n = 0; n < count; ++n) {
    all.col(n) *= slope_of_free(forward_.parameters()[free_[static_cast<std::size_t>(n)]], q[n]);
  }
  return all;
}

Search::Found Search::from(const Forward::Values& start, const reference::LeastSquaresRule& rule) const {
  if (free_.empty()) { return {.values = start, .cost = residuals(start).squaredNorm(), .converged = true}; }
  Eigen::VectorXd q(static_cast<Eigen::Index>(free_.size()));
  for (std::size_t n = 0; n < free_.size(); ++n) {
    q[static_cast<Eigen::Index>(n)] = to_free(forward_.parameters()[free_[n]], start[free_[n]]);
  }
  const reference::LeastSquaresProblem problem{
      .residuals = [&](const Eigen::VectorXd& at) { return residuals(values_at(start, at)); },
      .jacobian = [&](const Eigen::VectorXd& at) { return jacobian(values_at(start, at), at); }};
  const reference::LeastSquaresSolution solution = reference::least_squares(problem, q, rule);
  return {.values = values_at(start, solution.x),
          .cost = solution.cost(),
          .iterations = solution.iterations,
          .converged = solution.converged};
}

}  // namespace palpate::calibration
