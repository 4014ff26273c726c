// SPDX-License-Identifier: MIT
#include <cmath>

#include <Eigen/QR>

#include "validation/gate/curve_change.hpp"

namespace palpate::gate {

namespace {

/// Columns: what a lag of one sample, a gain of one and an offset of one add to `before`.
Eigen::MatrixXd directions_of(const Eigen::Ref<const Eigen::VectorXd>& before) {
  const Eigen::Index inner = before.size() - 2;
  Eigen::MatrixXd columns(inner, 3);
  columns.col(0) = -0.5 * (before.tail(inner) - before.head(inner));
  columns.col(1) = before.segment(1, inner);
  columns.col(2).setOnes();
  return columns;
}

bool evenly_spaced(const std::vector<double>& x) {
  const double step = (x.back() - x.front()) / static_cast<double>(x.size() - 1);
  constexpr double rounding = 1e-6;
  for (std::size_t n = 1; n < x.size(); ++n) {
    if (!(std::abs(x[n] - x[n - 1] - step) <= rounding * std::abs(step))) { return false; }
  }
  return step != 0.0;
}

}  // namespace

double lag_in_samples(const std::vector<double>& x, const std::vector<double>& before,
                      const std::vector<double>& now) {
  constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
  constexpr double collinear = 1e-3;  // a ramp that is late is a ramp with an offset
  if (before.size() < least_samples_for_lag || now.size() != before.size() || !evenly_spaced(x)) { return nothing; }
  const auto size = static_cast<Eigen::Index>(before.size());
  const Eigen::Map<const Eigen::VectorXd> was(before.data(), size);
  const Eigen::Map<const Eigen::VectorXd> is(now.data(), size);
  Eigen::MatrixXd columns = directions_of(was);
  const Eigen::VectorXd difference = (is - was).segment(1, size - 2);
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> solver;
  const Eigen::RowVectorXd scale = columns.colwise().norm();
  if (!(scale.minCoeff() > 0.0)) { return nothing; }
  columns.array().rowwise() /= scale.array();
  solver.setThreshold(collinear);
  solver.compute(columns);
  if (solver.rank() < 3) { return nothing; }
  Eigen::VectorXd found = solver.solve(difference);
  const double lag = found(0) / scale(0);
  const double told = found(0) * found(0) / difference.squaredNorm();  // columns have length one
  return told >= 0.5 ? lag : nothing;
}

}  // namespace palpate::gate
