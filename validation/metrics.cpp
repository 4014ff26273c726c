// SPDX-License-Identifier: MIT
#include "validation/metrics.hpp"

#include <cmath>
#include <limits>

namespace palpate {

namespace {
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
}

TrajectoryError trajectory_error(const Eigen::Ref<const Eigen::MatrixXd>& candidate,
                                 const Eigen::Ref<const Eigen::MatrixXd>& truth,
                                 const Eigen::Ref<const Eigen::VectorXd>& start) {
  const bool comparable = candidate.rows() == truth.rows() && candidate.cols() == truth.cols() &&
                          truth.size() > 0 && start.size() == truth.rows() &&
                          candidate.allFinite() && truth.allFinite() && start.allFinite();
  if (!comparable) { return {nan, nan, nan, nan}; }
  const Eigen::MatrixXd motion = truth.colwise() - Eigen::VectorXd(start);
  const Eigen::MatrixXd difference = candidate - truth;
  TrajectoryError error;
  error.peak = motion.cwiseAbs().maxCoeff();
  error.maximum = difference.cwiseAbs().maxCoeff() / error.peak;
  error.l2 = difference.norm() / motion.norm();
  error.final = difference.rightCols(1).cwiseAbs().maxCoeff() / error.peak;
  return error;
}

ObservedOrder observed_order(std::span<const double> h, std::span<const double> error,
                             double floor, double ceiling) {
  std::vector<double> x;
  std::vector<double> y;
  ObservedOrder order;
  order.monotone = true;
  for (std::size_t n = 0; n < h.size() && n < error.size(); ++n) {
    if (!(error[n] > floor && error[n] < ceiling)) { continue; }
    x.push_back(std::log(h[n]));
    y.push_back(std::log(error[n]));
    const std::size_t last = x.size() - 1;
    if (last > 0 && (x[last] - x[last - 1]) * (y[last] - y[last - 1]) <= 0.0) {
      order.monotone = false;
    }
  }
  order.rungs = static_cast<int>(x.size());
  if (order.rungs < 4) {
    order.slope = nan;
    order.r_squared = nan;
    return order;
  }
  const Eigen::Map<const Eigen::ArrayXd> log_h(x.data(), order.rungs);
  const Eigen::Map<const Eigen::ArrayXd> log_e(y.data(), order.rungs);
  const Eigen::ArrayXd dx = log_h - log_h.mean();
  const Eigen::ArrayXd dy = log_e - log_e.mean();
  order.slope = (dx * dy).sum() / dx.square().sum();
  order.r_squared = std::pow((dx * dy).sum(), 2) / (dx.square().sum() * dy.square().sum());
  return order;
}

}  // namespace palpate
