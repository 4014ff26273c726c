// SPDX-License-Identifier: MIT
#pragma once
/// Samples on a uniform grid, and the only place where samples are moved from one grid to another.
/// A gap is NaN and stays one: nothing is interpolated across it.

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace palpate::comparison {

inline constexpr double not_measured = std::numeric_limits<double>::quiet_NaN();

/// Squares and their sums stay numbers up to here; nothing larger is a measurement.
inline constexpr double largest_value = 1e100;

/// An interval longer than this many usual ones is a gap: a single missing sample makes it 2.
inline constexpr double longest_bridge = 1.5;

struct Grid {
  double start = 0.0;     ///< [s]
  double step = 0.01;     ///< [s]
  std::size_t count = 0;  ///< instants
};

struct Samples {
  double start = 0.0;           ///< [s]
  double step = 0.01;           ///< [s]
  std::vector<double> value{};  ///< NaN where nothing was measured

  [[nodiscard]] std::size_t size() const { return value.size(); }
  [[nodiscard]] double time(std::size_t n) const { return start + step * static_cast<double>(n); }
  [[nodiscard]] double end() const { return value.empty() ? start : time(value.size() - 1); }
  [[nodiscard]] Grid grid() const { return {start, step, value.size()}; }
  /// The index at or before a time, clamped to the samples.
  [[nodiscard]] std::size_t index_at(double t) const;
  /// How many steps a duration [s] holds, at least one.
  [[nodiscard]] std::size_t steps(double duration) const;
};

/// Samples [begin, end) without a gap.
struct Stretch {
  std::size_t begin = 0;
  std::size_t end = 0;
  [[nodiscard]] std::size_t size() const { return end - begin; }
};
std::vector<Stretch> finite_stretches(std::span<const double> value);
Stretch longest_stretch(std::span<const double> value);

/// Median of the intervals between times [s]; NaN below two of them.
double usual_interval(std::span<const double> time);

/// Every instant from `begin` to `end` [s] that lies on start + n step.
Grid grid_between(double begin, double end, double anchor, double step);

/// Linear between neighbours no further apart than `longest_bridge` usual intervals and both
/// finite; NaN elsewhere and outside. An instant within 1e-4 of an interval of a sample takes that
/// sample. `time` is strictly increasing.
Samples resample(std::span<const double> time, std::span<const double> value, const Grid& grid);
Samples resample(const Samples& samples, const Grid& grid);

/// The samples on a grid of their own usual interval, which starts at the first of them.
Samples regular(std::span<const double> time, std::span<const double> value);

/// The q-quantile of the finite values, linear between order statistics; NaN when there is none.
double quantile(std::span<const double> value, double q);

/// The finite values alone.
std::vector<double> finite_only(std::span<const double> value);

// The one low-pass of the comparison, the same for recorded and simulated traces.

/// Butterworth low-pass of second order run forward and backward: no phase, gain 1 / (1 + w^4) with
/// w = tan(pi f / rate) / tan(pi cutoff / rate), so 1/2 at the cut-off, and fourth order in all.
/// Each stretch between gaps is filtered alone. Its ends are extended by their own odd reflection
/// over three periods of the cut-off (less in shorter stretches), and both runs start in the steady
/// state of their first sample, so a straight line passes unchanged to its ends. Stretches of one
/// or two samples stay as they are.
Samples zero_phase(const Samples& samples, double cutoff);

/// True when a rate [Hz] leaves such a filter something to take away: cut-off below 0.4 of it.
bool can_filter(double cutoff, double rate);

/// Shares of the variance of white noise that pass the filter, and that stay in what it takes away.
struct NoiseShares {
  double passed = 1.0;
  double removed = 0.0;
};
NoiseShares noise_shares(double cutoff, double rate);

// Distances of a whole trace from another. They explain a verdict and never make one: none is sharp
// on the event (docs/comparison.md has the table of what each is blind to).

/// Over the samples where both are numbers; NaN where a figure is not defined.
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

// Distances between motions, and orders of convergence. Everything is finite-first: a value that
// is not finite, or a shape that does not match, gives NaN, which no bound holds.

struct TrajectoryError {
  double maximum = 0.0;  ///< largest |candidate - truth| over the peak of |truth - start| [1]
  double l2 = 0.0;       ///< root mean square over coordinates and times, over the truth's own [1]
  double final = 0.0;    ///< at the last instant, over the peak [1]
  double peak = 0.0;     ///< largest |truth - start| [m]: the scale
};

/// Both dof x times, sampled at the same instants; `start` is the position that motion is measured
/// from (truth.col(0) when the caller has nothing better). A candidate that stopped early gives
/// NaN.
TrajectoryError trajectory_error(const Eigen::Ref<const Eigen::MatrixXd>& candidate,
                                 const Eigen::Ref<const Eigen::MatrixXd>& truth,
                                 const Eigen::Ref<const Eigen::VectorXd>& start);

/// Slope of log e over log h by least squares, with sign, over the rungs above round-off
/// (e > floor) and below `ceiling`.
struct ObservedOrder {
  double slope = 0.0;  ///< NaN with fewer than four rungs
  double r_squared = 0.0;
  int rungs = 0;          ///< used
  bool monotone = false;  ///< the used errors fall with h
};
ObservedOrder observed_order(std::span<const double> h, std::span<const double> error, double floor,
                             double ceiling = 0.1);

}  // namespace palpate
