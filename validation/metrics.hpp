// SPDX-License-Identifier: MIT
#pragma once
/// Distances between motions, and orders of convergence. Everything is finite-first: a value that
/// is not finite, or a shape that does not match, gives NaN, which no bound holds.

#include <span>
#include <vector>

#include <Eigen/Core>

namespace palpate {

struct TrajectoryError {
  double maximum = 0.0;  ///< largest |candidate - truth| over the peak of |truth - start| [1]
  double l2 = 0.0;       ///< root mean square over coordinates and times, over the truth's own [1]
  double final = 0.0;    ///< at the last instant, over the peak [1]
  double peak = 0.0;     ///< largest |truth - start| [m]: the scale
};

/// Both dof x times, sampled at the same instants; `start` is the position that motion is measured
/// from (truth.col(0) when the caller has nothing better). A candidate that stopped early gives NaN.
TrajectoryError trajectory_error(const Eigen::Ref<const Eigen::MatrixXd>& candidate,
                                 const Eigen::Ref<const Eigen::MatrixXd>& truth,
                                 const Eigen::Ref<const Eigen::VectorXd>& start);

/// Slope of log e over log h by least squares, with sign, over the rungs above round-off
/// (e > floor) and below `ceiling`.
struct ObservedOrder {
  double slope = 0.0;      ///< NaN with fewer than four rungs
  double r_squared = 0.0;
  int rungs = 0;           ///< used
  bool monotone = false;   ///< the used errors fall with h
};
ObservedOrder observed_order(std::span<const double> h, std::span<const double> error,
                             double floor, double ceiling = 0.1);

}  // namespace palpate
