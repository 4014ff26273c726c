// SPDX-License-Identifier: MIT
#pragma once
/// Samples on a uniform time grid and resampling. A gap is NaN and stays NaN: no value is
/// interpolated across it.

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace palpate::comparison {

inline constexpr double not_measured = std::numeric_limits<double>::quiet_NaN();

/// Largest absolute value that is treated as a measurement; sums of squares of such values do not
/// overflow.
inline constexpr double largest_value = 1e100;

/// Longest interval that is not a gap, as a multiple of the usual interval. One missing sample
/// gives 2.
inline constexpr double longest_bridge = 1.5;

struct Grid {
  double start = 0.0;     ///< [s]
  double step = 0.01;     ///< [s]
  std::size_t count = 0;  ///< instants
};

struct Samples {
  double start = 0.0;           ///< [s]
  double step = 0.01;           ///< [s]
  std::vector<double> value{};  ///< NaN in gaps

  [[nodiscard]] std::size_t size() const { return value.size(); }
  [[nodiscard]] double time(std::size_t n) const { return start + step * static_cast<double>(n); }
  [[nodiscard]] double end() const { return value.empty() ? start : time(value.size() - 1); }
  [[nodiscard]] Grid grid() const { return {start, step, value.size()}; }
  /// Returns the index of the last sample at or before a time [s], clamped to the samples.
  [[nodiscard]] std::size_t index_at(double t) const;
  /// Returns the number of steps in a duration [s], at least 1.
  [[nodiscard]] std::size_t steps(double duration) const;
};

/// Range [begin, end) of samples without a gap.
struct Stretch {
  std::size_t begin = 0;
  std::size_t end = 0;
  [[nodiscard]] std::size_t size() const { return end - begin; }
};
std::vector<Stretch> finite_stretches(std::span<const double> value);
Stretch longest_stretch(std::span<const double> value);

/// Returns the median interval between times [s]; NaN for fewer than two times.
double usual_interval(std::span<const double> time);

/// Returns the grid of all instants anchor + n step between `begin` and `end` [s].
Grid grid_between(double begin, double end, double anchor, double step);

/// Interpolates linearly between finite neighbours that are at most `longest_bridge` usual
/// intervals apart; NaN elsewhere. An instant within 1e-4 of an interval of a sample takes that
/// sample. `time` must be strictly increasing.
Samples resample(std::span<const double> time, std::span<const double> value, const Grid& grid);
Samples resample(const Samples& samples, const Grid& grid);

/// Resamples to a grid with the usual interval of the samples that starts at the first sample.
Samples regular(std::span<const double> time, std::span<const double> value);

/// Returns the q-quantile of the finite values, linear between order statistics; NaN without finite
/// values.
double quantile(std::span<const double> value, double q);

/// Returns the finite values.
std::vector<double> finite_only(std::span<const double> value);

// Low-pass filter of the comparison, identical for recorded and simulated traces.

/// Applies a second-order Butterworth low-pass forward and backward: zero phase, gain 1 / (1 + w^4)
/// with w = tan(pi f / rate) / tan(pi cutoff / rate), so 1/2 at the cut-off [Hz]. Each stretch
/// between gaps is filtered separately. Its ends are extended by odd reflection over three periods
/// of the cut-off (less in shorter stretches). Both passes start in the steady state of their first
/// sample, so a straight line is unchanged. Stretches of one or two samples are not filtered.
Samples zero_phase(const Samples& samples, double cutoff);

/// Returns true if the cut-off [Hz] is below 0.4 of the sampling rate [Hz].
bool can_filter(double cutoff, double rate);

/// Shares of the variance of white noise in the filtered signal and in the removed part [1].
struct NoiseShares {
  double passed = 1.0;
  double removed = 0.0;
};
NoiseShares noise_shares(double cutoff, double rate);

// Distance measures between two traces. They explain a verdict but do not decide it: none is
// specific to the event (docs/comparison.md lists the limits of each).

/// Distance measures over the samples where both traces are finite; NaN where a measure is
/// undefined.
struct TraceErrors {
  std::size_t samples = 0;
  double rmse = 0.0;       ///< root mean square of simulated - recorded, in the traces' unit
  double nrmse = 0.0;      ///< rmse over the recorded range, largest - smallest [1]
  double mean = 0.0;       ///< mean of simulated - recorded, in the traces' unit
  double magnitude = 0.0;  ///< Sprague-Geers M = sqrt(sum s^2 / sum r^2) - 1, signed [1]
  double phase = 0.0;      ///< Sprague-Geers P = acos(sum s r / sqrt(sum s^2 sum r^2)) / pi [1]
  double combined = 0.0;   ///< Sprague-Geers C = sqrt(M^2 + P^2) [1]
};
TraceErrors trace_errors(std::span<const double> simulated, std::span<const double> recorded);

}  // namespace palpate::comparison

namespace palpate {

// Distances between motions and observed orders of convergence. A value that is not finite or a
// shape that does not match gives NaN, which fails every bound.

/// Returns the instants 0, step, ... count * step [s].
std::vector<double> tick_times(double step, long count);

struct TrajectoryError {
  double maximum = 0.0;  ///< largest |candidate - truth| over the peak of |truth - start| [1]
  double l2 = 0.0;       ///< root mean square over coordinates and times, over the truth's own [1]
  double final = 0.0;    ///< at the last instant, over the peak [1]
  double peak = 0.0;     ///< largest |truth - start| [m]: the scale
};

/// Returns the error of a candidate relative to the truth. Both are dof x times at the same
/// instants; `start` is the reference position of the motion (truth.col(0) by default). A candidate
/// that stopped early gives NaN.
TrajectoryError trajectory_error(const Eigen::Ref<const Eigen::MatrixXd>& candidate,
                                 const Eigen::Ref<const Eigen::MatrixXd>& truth,
                                 const Eigen::Ref<const Eigen::VectorXd>& start);

/// Order of convergence: least-squares slope of log e over log h, over the points with floor < e <
/// `ceiling`.
struct ObservedOrder {
  double slope = 0.0;  ///< NaN with fewer than four points
  double r_squared = 0.0;
  int rungs = 0;          ///< number of points used
  bool monotone = false;  ///< the used errors decrease with h
};
ObservedOrder observed_order(std::span<const double> h, std::span<const double> error, double floor,
                             double ceiling = 0.1);

/// Uncertainty of the value on the finest of three grids, relative to it.
struct GridConvergence {
  double order = 0.0;  ///< observed
  double index = 0.0;  ///< grid convergence index; NaN if a value is not finite
};
/// Returns the grid convergence index of the last three values (P. J. Roache 1998; refinement
/// ratios that differ: I. B. Celik et al., J. Fluids Eng. 130, 078001, 2008). An order below 0.5 or
/// above 2.5 is not credible: the first order and the factor 3 are used then. `h` decreases.
GridConvergence grid_convergence(std::span<const double> h, std::span<const double> value);

}  // namespace palpate
